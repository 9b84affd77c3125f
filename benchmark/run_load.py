#!/usr/bin/env python3
"""Puts a running slam_node under load and writes a report: sustained rates, processor time,
latency, memory, and what a storm of scans, late transforms, stuck subscribers and a deadline do.

Build and source the workspace, leave the machine alone, then:

    benchmark/run_load.py [--out DIR] [--minutes 10] [--hours 12] [--only NAME]...

Every scenario has a ROS master of its own. The rooms are simulated; 1040 beams a scan.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

from load_session import RawScan, Session, simulated
from report import default_folder, heading


def quantiles(seconds):
    """p50, p95, p99 and the largest, in milliseconds."""
    ordered = sorted(seconds) or [float('nan')]
    return [1e3 * ordered[int(q * (len(ordered) - 1))] for q in (0.5, 0.95, 0.99, 1.0)]


def play(session, recording, seconds):
    """Plays in real time; what was sent, and the node's processor time and memory on the way."""
    start = time.time() + 0.5
    cpu = session.cpu_seconds()
    scans = 0
    memory = []
    for due, stamp, message in recording.drive(start):
        if due - start > seconds:
            break
        time.sleep(max(0.0, due - time.time()))
        session.publish(stamp, message)
        scans += isinstance(message, RawScan)
        if due - start >= len(memory):
            memory.append(session.memory_mb())
    wall = time.time() - start
    cpu = session.cpu_seconds() - cpu
    time.sleep(1.5)  # diagnostics come once a second
    return {'scans': scans, 'rate': scans / wall, 'cpu': cpu / wall,
            'memory': [memory[min(60, len(memory) // 2)], memory[-1], max(memory)]}


def outcome(session, played):
    measured = session.measured
    return dict(played, used=len(measured.match_times), skipped=measured.skipped,
                to_pose=quantiles(measured.to_pose), to_transform=quantiles(measured.to_transform()),
                match=quantiles(measured.match_times), unproven=measured.unproven)


def steady(folder, rate, matcher, seconds, settings=(), late_transforms=0.0):
    # Slowly, so that the way lasts nearly ten minutes before it turns.
    recording = simulated(folder, rate, '--speed', '0.2', '--duration', str(min(seconds, 560.0)),
                          late_transforms=late_transforms)
    with Session(matcher, settings) as session:
        return outcome(session, play(session, recording, seconds))


def storm(folder):
    recording = simulated(folder, 1000, '--duration', '10')
    with Session('olson') as session:
        return outcome(session, play(session, recording, 10.0))


def stuck_subscribers(folder):
    recording = simulated(folder, 40, '--speed', '0.2', '--duration', '60')
    with Session('olson', ['map_update_interval=0.2']) as session:
        stuck = [session.start('rostopic', 'echo', topic)
                 for topic in ('/map', '/path', '/pose', '/tf')]
        time.sleep(3.0)
        for process in stuck:
            process.send_signal(signal.SIGSTOP)
        return outcome(session, play(session, recording, 60.0))


def wait_for_poses(session, count):
    give_up = time.time() + 20.0
    while len(session.measured.to_pose) < count:
        if time.time() > give_up:
            sys.exit('only %d poses came of %d scans' % (len(session.measured.to_pose), count))
        time.sleep(0.0002)


def soak(folder, hours):
    """Scans at 5 Hz by simulated time, as fast as the node takes them; a row each hour."""
    recording = simulated(folder, 5, odometry_rate=10)
    rows = []
    with Session('olson', ['max_lag=0'], sim_time=True) as session:
        start = 1000.0
        cpu, scans, scans_before = session.cpu_seconds(), 0, 0
        for due, stamp, message in recording.drive(start):
            if isinstance(message, RawScan):
                wait_for_poses(session, scans - 10)
                scans += 1
            session.clock.publish(stamp)
            session.publish(stamp, message)
            if due - start < 3600.0 * (len(rows) + 1):
                continue
            now = session.cpu_seconds()
            rows.append({'memory': session.memory_mb(),
                         'cpu_ms': 1e3 * (now - cpu) / (scans - scans_before),
                         'match': quantiles(session.measured.match_times[scans_before:]),
                         'skipped': scans - len(session.measured.to_pose)})
            cpu, scans_before = now, scans
            if len(rows) >= hours:
                return rows


def scenarios(options):
    longest = 60.0 * options.minutes
    return {
        'olson, 40 Hz': lambda folder: steady(folder, 40, 'olson', longest),
        'olson, 20 Hz': lambda folder: steady(folder, 20, 'olson', 60.0),
        'hough, 40 Hz': lambda folder: steady(folder, 40, 'hough', 60.0),
        'monte_carlo, 40 Hz': lambda folder: steady(folder, 40, 'monte_carlo', 60.0),
        'transforms 0.3 s late': lambda folder: steady(folder, 40, 'olson', 30.0,
                                                       late_transforms=0.3),
        'stuck subscribers': stuck_subscribers,
        'storm of 1000 Hz': storm,
        # A window so wide that a search of it is seldom done in time.
        'deadline of 10 ms': lambda folder: steady(
            folder, 40, 'olson', 60.0,
            ['olson/deadline=0.01', 'olson/window_xy=4.0', 'olson/window_theta=0.8']),
        'soak': lambda folder: soak(folder, options.hours),
    }


def run_alone(name):
    """A scenario in a process of its own: a process can be one ROS node only."""
    done = subprocess.run([sys.executable] + sys.argv + ['--scenario', name],
                          stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def load_table(results):
    def all_of(values):
        return ' / '.join('%.1f' % value for value in values)

    lines = ['| scenario | scans/s | of them used | left out | processor, % of a core '
             '| match ms | scan to pose ms | scan to tf ms | memory MB: early, at the end, most |',
             '|---|---|---|---|---|---|---|---|---|']
    for name, result in results.items():
        left_out = ', '.join('%d %s' % (count, reason)
                             for reason, count in sorted(result['skipped'].items()) if count)
        lines.append('| %s | %.1f | %d of %d | %s | %.1f | %s | %s | %s | %s |' % (
            name, result['rate'], result['used'], result['scans'], left_out or '–',
            100.0 * result['cpu'], all_of(result['match']), all_of(result['to_pose']),
            all_of(result['to_transform']), all_of(result['memory'])))
    return lines


def soak_table(rows):
    lines = ['| hour | memory MB | processor ms a scan | match ms: p50 / p95 / p99 / max '
             '| scans without a pose yet |', '|---|---|---|---|---|']
    for hour, row in enumerate(rows, 1):
        lines.append('| %d | %.1f | %.2f | %s | %d |' % (
            hour, row['memory'], row['cpu_ms'],
            ' / '.join('%.2f' % value for value in row['match']), row['skipped']))
    return lines


def report(results):
    lines = heading('A node under load', 'run_load.py', [])
    lines += ['- slam_node alone in its process, 1040 beams a scan, odometry at 100 Hz, simulated '
              'rooms; the player and the listener share the machine',
              '- times are p50 / p95 / p99 / largest. Scan to pose: from the publishing of a scan to '
              'the reception of its pose, and so with the wait for odometry past its stamp. Scan to '
              'tf: to the first `map` transform that it changed', '']
    rows = results.pop('soak', None)
    if results:
        lines += load_table(results)
        deadline = results.get('deadline of 10 ms')
        if deadline:
            lines += ['', 'With the deadline, %d of %d answers came without proof.' %
                      (deadline['unproven'], deadline['used'])]
    if rows:
        lines += ['', 'Hours of scans at 5 Hz by simulated time, as fast as the node takes them, '
                  'forth and back through the rooms:', ''] + soak_table(rows)
    return '\n'.join(lines) + '\n'


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--out', default=default_folder(), help='folder of the report')
    parser.add_argument('--minutes', type=float, default=10.0, help='of the longest run')
    parser.add_argument('--hours', type=int, default=12, help='of the soak, by simulated time')
    parser.add_argument('--only', action='append',
                        help='a scenario; the others stay as they were measured')
    parser.add_argument('--scenario', help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.scenario:
        with tempfile.TemporaryDirectory() as folder:
            print(json.dumps(scenarios(options)[options.scenario](folder)))
        return
    os.makedirs(options.out, exist_ok=True)
    raw = os.path.join(options.out, 'load.json')
    unknown = set(options.only or []) - set(scenarios(options))
    if unknown:
        parser.error('no scenario is named %s; allowed: %s' % (
            ', '.join(sorted(unknown)), ', '.join(scenarios(options))))
    results = {}
    if options.only and os.path.exists(raw):
        with open(raw) as file:
            results = json.load(file)
    for name in options.only or scenarios(options):
        results[name] = run_alone(name)
        with open(raw, 'w') as file:
            json.dump(results, file, indent=1)
    path = os.path.join(options.out, 'LOAD.md')
    with open(path, 'w') as file:
        file.write(report({name: results[name] for name in scenarios(options) if name in results}))
    print(path)


if __name__ == '__main__':
    main()
