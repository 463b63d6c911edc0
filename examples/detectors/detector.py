"""A detector for `stiction bench detector`, in Python without packages.

    stiction bench detector 'python3 detector.py' --suite v1-trial

It reads a recording as JSON in each line of standard input, and writes an answer as JSON. The score is minus the kurtosis of the
OP. Behind a sticking valve an integrating controller ramps evenly, which gives a triangle.
"""

import json
import sys


def score(op):
    """Minus the fourth moment of the OP: -1.8 for a triangle, -3 for noise."""
    mean = sum(op) / len(op)
    second = sum((value - mean) ** 2 for value in op) / len(op)
    fourth = sum((value - mean) ** 4 for value in op) / len(op)
    return -fourth / second**2 if second > 0 else None


for line in sys.stdin:
    recording = json.loads(line)
    found = score([value for value in recording["op"] if value is not None])
    answer = {"id": recording["id"]}
    if found is None:
        answer["decision"] = "abstain"
    else:
        answer["score"] = found
        answer["decision"] = "sticks" if found > -1.9 else "does not stick"
    print(json.dumps(answer), flush=True)
