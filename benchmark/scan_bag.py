"""Bags with scans, as the programs beside this one open them."""

import rosbag

from text_rows import Mistake

SCAN = "sensor_msgs/LaserScan"


def open_scan_bag(path, topic):
    """A bag that has scans on this topic."""
    try:
        bag = rosbag.Bag(path)
        topics = bag.get_type_and_topic_info().topics
    except rosbag.ROSBagUnindexedException:
        raise Mistake(f"bag '{path}' has no index, as of a recording that was cut off; rosbag reindex makes one")
    except (OSError, rosbag.ROSBagException, ValueError) as mistake:
        raise Mistake(f"bag '{path}' cannot be read: {getattr(mistake, 'strerror', None) or mistake}")
    scans = sorted(name for name, info in topics.items() if info.msg_type == SCAN)
    if topic not in scans:
        raise Mistake(f"--scan: '{topic}' is no topic of {SCAN} in '{path}'; there: {', '.join(scans) or 'none'}")
    return bag
