"""A damped spring between the tool and the origin, as a process of its own: docs/parts/process-protocol.md."""
import json
import struct
import sys

asked = json.loads(sys.stdin.buffer.readline())
tools, options = asked["tools"], asked["options"]
stiffness, damping = options.get("stiffness", 200.0), options.get("damping", 0.0)
print(json.dumps({"protocol": 1, "has": ["energy", "reset"]}), flush=True)

request = struct.Struct(f"<IIQd{3 * tools}d")
answer = struct.Struct(f"<IIQQd{3 * tools}d")
STEP, RESET = 1, 2
before = None

while True:
    record = sys.stdin.buffer.read(request.size)
    if len(record) < request.size:
        break  # the run is over
    kind, _, n, step_s, *x = request.unpack(record)
    force, energy = [0.0] * (3 * tools), 0.0
    if kind == RESET:
        before = None
    else:
        v = [0.0 if before is None else (a - b) / step_s for a, b in zip(x, before or x)]
        force = [-stiffness * a - damping * b for a, b in zip(x, v)]
        energy = sum(0.5 * stiffness * a * a for a in x)
        before = x
    sys.stdout.buffer.write(answer.pack(kind, 0, n, 0, energy, *force))
    sys.stdout.buffer.flush()
