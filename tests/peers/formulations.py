"""Two independent formulations of a film stack, in as many digits as one likes.

Fields go like exp(-iωt), k > 0 absorbs, amplitudes are those of the electric field with the signs of Byrnes,
arXiv:1603.02720. Wave numbers are in units of 2π/λ.
"""

from dataclasses import dataclass, replace

from mpmath import mp, mpc, mpf

AMPLITUDES = ("r", "t", "r_back", "t_back")


@dataclass(frozen=True)
class Stack:
    """A case as exact numbers."""

    pol: str
    wavelength: mpf
    kind: str
    angle: mpf
    first: mpf
    last: tuple
    layers: tuple  # of (n, k, thickness)
    repeat: int

    @staticmethod
    def read(case):
        layers = tuple(tuple(map(mpf, layer)) for layer in case["layers"])
        assert case["n_first"][1] == 0
        return Stack(case["pol"], mpf(case["wavelength_nm"]), case["angle"]["kind"], mpf(case["angle"]["value"]),
                     mpf(case["n_first"][0]), tuple(map(mpf, case["n_last"])), layers, case["repeat"])

    def unrolled(self):
        return replace(self, layers=self.layers * self.repeat, repeat=1)

    def moved(self, move):
        """Every number of the input through `move`."""
        layers = tuple(tuple(move(x) for x in layer) for layer in self.layers)
        return replace(self, wavelength=move(self.wavelength), angle=move(self.angle), first=move(self.first),
                       last=tuple(move(x) for x in self.last), layers=layers)

    def direction(self):
        """kz of the first medium, and kx."""
        n = self.first
        if self.kind == "kx":
            return mp.sqrt((n - self.angle) * (n + self.angle)), self.angle
        if self.kind == "cos0":
            return n * self.angle, n * mp.sqrt((1 - self.angle) * (1 + self.angle))
        assert self.kind == "angle_deg"
        # cos 90° is 0, but π has no last digit.
        cos = mpf(0) if self.angle == 90 else mp.cos(self.angle * mp.pi / 180)
        return n * abs(cos), n * mp.sin(self.angle * mp.pi / 180)

    def ends(self):
        """kz of the first and of the last medium."""
        kz0, kx = self.direction()
        last = mpc(*self.last)
        return kz0, kz0 if last == self.first else outgoing(last, kx)

    def shares(self, a):
        """R, T, their likes from behind (None where no light travels there), and A."""
        kz0, kzn = self.ends()
        last = mpc(*self.last)
        flux = mp.re(kzn) if self.pol == "s" else mp.re(last * mp.conj(kzn / last))
        back = self.last[1] == 0 and mp.re(kzn) > 0
        out = {"R": abs(a["r"]) ** 2, "T": abs(a["t"]) ** 2 * flux / kz0 if kz0 else mpf(0)}
        out["R_back"] = abs(a["r_back"]) ** 2 if back else None
        out["T_back"] = abs(a["t_back"]) ** 2 * kz0 / mp.re(kzn) if back else None
        out["A"] = 1 - out["R"] - out["T"]
        return out


def outgoing(n, kx):
    """kz with Im ≥ 0, and Re ≥ 0 where Im = 0."""
    root = mp.sqrt(mpc(n - kx) * (n + kx))
    return -root if mp.im(root) < 0 else root


def power(one, times, product):
    """one · one · … by repeated squaring."""
    out = None
    while times:
        if times & 1:
            out = one if out is None else product(out, one)
        one, times = product(one, one) if times > 1 else one, times >> 1
    return out


def abeles(stack, digits):
    """The characteristic matrix: tangential fields in front = M times those behind (Born & Wolf, § 1.6.2)."""
    with mp.workdps(digits + 20):
        kz0, kx = stack.direction()
        kzn, (p, last) = stack.ends()[1], (stack.pol == "p", mpc(*stack.last))
        q = lambda n, kz: kz / n**2 if p else kz

        def matrix(layer):
            n, thickness = mpc(layer[0], layer[1]), 2 * mp.pi * layer[2] / stack.wavelength
            kz = kz0 if n == stack.first else outgoing(n, kx)
            cos, sin = mp.cos_sin(kz * thickness)
            over = (sin / kz if kz else thickness) * (n**2 if p else 1)
            return cos, mpc(0, -1) * over, mpc(0, -1) * q(n, kz) * sin, cos

        known, m = {}, (mpf(1), mpf(0), mpf(0), mpf(1))
        for layer in stack.layers:
            if layer not in known:
                known[layer] = matrix(layer)
            m = times(m, known[layer])
        m = power(m, stack.repeat, times) if stack.layers else m
        q0, qn = q(stack.first, kz0), q(last, kzn)
        u, v, ub, vb = m[0] + m[1] * qn, m[2] + m[3] * qn, m[3] + m[1] * q0, m[2] + m[0] * q0
        # One factor of both transmissions, so that neither divides by a kz of 0.
        t = 2 / (q0 * u + v) / (stack.first * last if p else 1)
        return {"r": (q0 * u - v) / (q0 * u + v), "t": t * kz0, "r_back": (qn * ub - vb) / (qn * ub + vb),
                "t_back": t * kzn}


def times(a, b):
    return a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]


def scattering(stack, digits):
    """Fresnel's coefficients of every interface and a phase per layer, joined by Redheffer's star product.

    A kz of 0 would leave 0/0. All amplitudes are even in the kz of a layer and smooth in those of the ends: there
    10^-(2 digits) stands for 0, and 5 times the digits are kept."""
    media = [(stack.first, mpf(0)), *(layer[:2] for layer in stack.layers), stack.last]
    with mp.workdps(digits + 20):
        kz0, kx = stack.direction()
        zero = any(mpc(*m) == kx for m in media[1:]) or kz0 == 0
    with mp.workdps(5 * digits if zero else digits + 20):
        kz0, kx = stack.direction()
        tiny = mpf(10) ** (-2 * digits)
        kz0 = kz0 or tiny
        waves = [(mpc(*m), kz0 if mpc(*m) == stack.first else outgoing(mpc(*m), kx) or tiny) for m in media]
        first, inner, last = waves[0], waves[1:-1], waves[-1]
        interface = lambda a, b: fresnel(a, b, stack.pol == "p")
        if not inner:
            return named(interface(first, last))
        phase = [mp.exp(mpc(0, 2) * mp.pi * kz * layer[2] / stack.wavelength)
                 for (_, kz), layer in zip(inner, stack.layers)]

        def cell(before):
            s = None
            for medium, e in zip(inner, phase):
                face = interface(before, medium)
                s, before = through(face if s is None else star(s, face), e), medium
            return s

        s = cell(first)
        if stack.repeat > 1:
            s = star(s, power(cell(inner[-1]), stack.repeat - 1, star))
        return named(star(s, interface(inner[-1], last)))


def named(s):
    return dict(zip(AMPLITUDES, s))


def fresnel(a, b, p):
    """r, t, and the same from behind."""
    (n1, k1), (n2, k2) = a, b
    if a == b:
        return mpf(0), mpf(1), mpf(0), mpf(1)
    x, y = (n2 * k1 / n1, n1 * k2 / n2) if p else (k1, k2)
    r, t = (x - y) / (x + y), 2 / (x + y)
    return r, t * k1, -r, t * k2


def through(s, e):
    """s and a way behind it."""
    r, t, rb, tb = s
    return r, t * e, rb * e * e, tb * e


def star(a, b):
    """a, then b."""
    (r1, t1, r1b, t1b), (r2, t2, r2b, t2b) = a, b
    trapped = 1 / (1 - r1b * r2)
    return r1 + t1b * r2 * t1 * trapped, t1 * t2 * trapped, r2b + t2 * r1b * t2b * trapped, t1b * t2b * trapped
