"""Bags with scans, as the programs beside this one open them."""

import os

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


def only_scan_topic(path):
    """None where there are several, or none, or no file."""
    if not os.path.isfile(path):
        return None
    with rosbag.Bag(path) as bag:
        topics = [name for name, info in bag.get_type_and_topic_info().topics.items() if info.msg_type == SCAN]
    return topics[0] if len(topics) == 1 else None


def rewrite(path, topic, target, copy):
    """What copy(bag, out) returns, which writes what is taken of a bag with scans; the target is there only once it is whole."""
    aside = f"{target}.{os.getpid()}"
    try:
        with open_scan_bag(path, topic) as bag:
            try:
                with rosbag.Bag(aside, "w") as out:
                    written = copy(bag, out)
            except Mistake:
                raise
            except Exception as mistake:  # damaged bytes make rosbag raise whatever comes of them
                raise Mistake(f"'{path}' cannot be copied to '{target}': "
                              f"{getattr(mistake, 'strerror', None) or mistake or type(mistake).__name__}")
        os.rename(aside, target)
        return written
    finally:
        if os.path.exists(aside):
            os.remove(aside)
