"""The robot's side of EGM path correction with the messages of ABBRobotEGM, against a live run. peer_egm.py PORT CYCLE_MS"""

import math
import socket
import sys
import time

from ABBRobotEGM._egm_protobuf import egm_pb2

port, cycle_s = int(sys.argv[1]), float(sys.argv[2]) * 1e-3
link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.connect(("127.0.0.1", port))
STOPPED, RUNNING = 2, 3
number, x, y, took_ms = 0, 0.0, 0.0, []
counts = {"corrections": 0, "holds": 0, "silent": 0}


def cycle(mci):
    """One message; the answer's offset, "hold", or None for silence."""
    global number, x
    number += 1
    x += 10.0 * cycle_s
    robot = egm_pb2.EgmRobot()
    robot.header.seqno, robot.header.tm = number, round(number * cycle_s * 1e3)
    robot.header.mtype = egm_pb2.EgmHeader.MessageType.Value("MSGTYPE_DATA")
    robot.feedBack.joints.joints.extend([10.0] * 6)
    robot.feedBack.cartesian.pos.x, robot.feedBack.cartesian.pos.y, robot.feedBack.cartesian.pos.z = x, y, 5.0
    robot.feedBack.cartesian.orient.u0 = 1.0
    robot.feedBack.cartesian.orient.u1 = robot.feedBack.cartesian.orient.u2 = robot.feedBack.cartesian.orient.u3 = 0.0
    robot.planned.cartesian.pos.x = robot.planned.cartesian.pos.y = robot.planned.cartesian.pos.z = 1.0
    robot.motorState.state, robot.mciState.state, robot.rapidExecState.state = 1, mci, 2
    robot.mciConvergenceMet, robot.utilizationRate = False, 12.5
    start = time.perf_counter()
    link.send(robot.SerializeToString())
    while True:
        left = cycle_s - (time.perf_counter() - start)
        link.settimeout(max(left, 1e-4))
        try:
            answer = egm_pb2.EgmSensorPathCorr.FromString(link.recv(65536))
        except (TimeoutError, ConnectionRefusedError):
            counts["silent"] += 1
            return None
        assert answer.IsInitialized()
        assert answer.header.mtype == egm_pb2.EgmHeader.MessageType.Value("MSGTYPE_PATH_CORRECTION")
        if answer.header.tm == robot.header.tm:
            break
    took_ms.append((time.perf_counter() - start) * 1e3)
    time.sleep(max(0.0, cycle_s - (time.perf_counter() - start)))
    if not answer.HasField("pathCorr"):
        counts["holds"] += 1
        return "hold"
    counts["corrections"] += 1
    assert answer.pathCorr.pos.x == answer.pathCorr.pos.z == 0.0 and answer.pathCorr.age < 2000
    return answer.pathCorr.pos.y


def move(seconds):
    """A movement under EGM that follows the offsets; the largest step."""
    global y
    largest = 0.0
    for _ in range(3):
        cycle(STOPPED)
    y, began = 0.0, time.perf_counter()
    while time.perf_counter() - began < seconds:
        answer = cycle(RUNNING)
        if isinstance(answer, float):
            assert math.isfinite(answer)
            largest, y = max(largest, abs(answer - y)), answer
    return largest


time.sleep(1.5)
largest = move(4.0)
assert counts["corrections"] > 10 and counts["holds"] > 3, counts
assert largest <= 0.1 + 1e-9, largest
# Nothing for longer than robot_silent_s: STOP, which is silence. The next movement is answered again.
time.sleep(0.6)
for key in counts:
    counts[key] = 0
for _ in range(20):
    cycle(RUNNING)
assert counts["silent"] == 20, counts
assert move(2.0) <= 0.1 + 1e-9
assert counts["holds"] > 3, counts
took_ms.sort()
print(
    f"egm: {len(took_ms)} answers at {sys.argv[2]} ms, p50 {took_ms[len(took_ms) // 2]:.3f}, "
    f"p99 {took_ms[int(len(took_ms) * 0.99)]:.3f}, max {took_ms[-1]:.3f} ms, largest step {largest:.4f} mm"
)
