"""pymodbus against a live run's registers. peer_modbus.py PORT"""

import sys
import time

from pymodbus.client import ModbusTcpClient

READS = 10_000
client = ModbusTcpClient("127.0.0.1", port=int(sys.argv[1]))
began = time.time()
while not client.connect():
    assert time.time() - began < 30, "nobody listens"
    time.sleep(0.1)

took_ms, torn, paths = [], 0, {}
for i in range(READS):
    read = client.read_input_registers if i % 2 else client.read_holding_registers
    start = time.perf_counter()
    answer = read(1000, count=13)
    took_ms.append((time.perf_counter() - start) * 1e3)
    assert not answer.isError(), answer
    total, decision = (answer.registers[0] << 16) | answer.registers[1], answer.registers[2]
    torn += (total == 0x80000000) != (decision == 1)
    # A cycle has one path: what is read of the same cycle must be the same.
    path = (answer.registers[6] << 16) | answer.registers[7]
    torn += paths.setdefault(answer.registers[12], path) != path
assert torn == 0, f"{torn} torn values"
assert len(paths) > 10, "the heartbeat stands"

# Stop, and what refuses.
assert not client.write_register(0, 2).isError()
time.sleep(0.2)
assert list(client.read_holding_registers(300, count=2).registers) == [4, 9], "STOP, asked"
assert not client.write_registers(0, [1, 7, 2500]).isError()
time.sleep(0.2)
assert client.read_holding_registers(300, count=1).registers[0] != 4, "reset"
assert list(client.read_holding_registers(0, count=3).registers) == [1, 7, 2500]
assert client.write_register(300, 1).isError() and client.read_input_registers(1010, count=20).isError()

took_ms.sort()
print(
    f"modbus: {READS} reads, p50 {took_ms[READS // 2]:.3f}, p99 {took_ms[int(READS * 0.99)]:.3f}, "
    f"max {took_ms[-1]:.3f} ms, torn {torn}"
)
