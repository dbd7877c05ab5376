"""RSIPI's emulated KUKA against a live run, with the setup of the documentation. peer_rsi.py SETUP.xml CYCLE_MS"""

import logging
import re
import sys
import time
from pathlib import Path

setup = re.sub(r"<IP_NUMBER>.*?</IP_NUMBER>", "<IP_NUMBER>127.0.0.1</IP_NUMBER>", Path(sys.argv[1]).read_text())
Path("setup.xml").write_text(setup)
cycle_ms = int(sys.argv[2])

from RSIPI.rsi_echo_server import EchoServer  # noqa: E402  (it makes a folder for its log where we are)

logging.getLogger().setLevel(logging.WARNING)
time.sleep(1.0)
robot = EchoServer("setup.xml", delay_ms=cycle_ms)
robot.start()
time.sleep(8.0)
cycles, faulty = (robot.ipoc_value - robot.first_ipoc) // cycle_ms, robot.faulty_packets
print(f"cycles {cycles}, faulty {faulty}, last answer {robot.last_received}")
robot.running = False
