"""Surfaces that tests of the program embed."""
import math


def ball(path, center, radius, n=12):
    """Quadrilaterals and triangles with texture coordinates, a seam, and poles of many corners' texture."""
    with open(path, "w") as file:
        for i in range(n + 1):
            for j in range(2 * n if 0 < i < n else 1):
                t, p = math.pi * i / n, math.pi * j / n
                file.write("v %r %r %r\n" % (center[0] + radius * math.sin(t) * math.cos(p), center[1] + radius * math.cos(t),
                                             center[2] - radius * math.sin(t) * math.sin(p)))
        for i in range(n + 1):
            for j in range(2 * n + 1):
                file.write("vt %r %r\n" % (j / (2 * n), i / n))

        def corner(i, j):
            number = 1 if i == 0 else 2 + 2 * n * (n - 1) if i == n else 2 + 2 * n * (i - 1) + j % (2 * n)
            return "%d/%d" % (number, i * (2 * n + 1) + j + 1)
        for i in range(n):
            for j in range(2 * n):
                quad = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]
                file.write("f " + " ".join(quad[1:] if i == 0 else quad[:2] + quad[3:] if i == n - 1 else quad) + "\n")
