"""Read a PC2 point cache as Blender's Mesh Cache modifier does and compare it with what was meant."""
import json
import os
import struct
import sys


def main(path):
    expected = json.load(open(path))
    data = open(os.path.join(os.path.dirname(path), expected["file"]), "rb").read()
    magic, version, points, start, rate, samples = struct.unpack_from("<12siiffi", data)
    assert magic == b"POINTCACHE2\0", magic
    assert (version, points, samples) == (1, expected["points"], expected["samples"])
    assert start == 0 and abs(rate - expected["rate"]) < 1e-7, (start, rate)
    assert len(data) == 32 + 12 * points * samples, len(data)
    values = struct.unpack_from("<%df" % (3 * points * samples), data, 32)
    for frame in range(samples):
        for i in range(3 * points):
            want = expected["per_frame"] * frame + expected["per_coordinate"] * i
            got = values[3 * points * frame + i]
            assert abs(got - want) <= 1e-6 * max(1, abs(want)), (frame, i, got, want)
    print("%d samples of %d points" % (samples, points))


main(sys.argv[1])
