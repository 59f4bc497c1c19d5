"""Film stacks at random, class by class; a case has the inputs of the schema `gonio-films-1`."""

import math
import random

AIR, GLASS = 1.0, 1.5


def make(seed, count):
    """`count` cases, their classes by turns, each drawn from its own random numbers."""
    out = []
    for i in range(count):
        maker = CLASSES[i % len(CLASSES)]
        rng = random.Random(f"{seed} {i}")
        case = {"cls": maker.__name__, "pol": rng.choice("sp"), "wavelength_nm": wavelength(rng), "angle": angle(rng),
                "n_first": AIR, "n_last": GLASS, "layers": [], "repeat": 1} | maker(rng)
        for end in ("n_first", "n_last"):
            case[end] = pair(case[end])
        case["layers"] = [[*pair(n), d] for n, d in case["layers"]]
        out.append({"id": f"u{seed}-{i}"} | case)
    return out


def pair(n):
    return [float(n.real), float(n.imag)]


def wavelength(rng):
    return rng.choice([550.0, rng.uniform(380, 780), round(rng.uniform(250, 2500), 1)])


def degrees(x):
    return {"kind": "angle_deg", "value": float(x)}


def cosine(x):
    return {"kind": "cos0", "value": float(x)}


def tangential(x):
    return {"kind": "kx", "value": float(x)}


def angle(rng):
    return rng.choice([degrees(0), degrees(round(rng.uniform(0, 85), 1)), degrees(rng.uniform(0, 89)),
                       cosine(rng.uniform(0.01, 1))])


def log(rng, low, high):
    return 10 ** rng.uniform(math.log10(low), math.log10(high))


def index(rng, low=1.0, high=3.0):
    return rng.choice([rng.uniform(low, high), round(rng.uniform(low, high), 2)]) or high


def thin(rng):
    return rng.choice([rng.uniform(1, 400), round(rng.uniform(1, 400))])


def absorbing(rng):
    return complex(index(rng), log(rng, 1e-8, 6))


def metal(rng):
    return complex(log(rng, 0.02, 3), rng.uniform(1, 9))


def random_layers(rng, most=12, lossy=0.3):
    return [(absorbing(rng) if rng.random() < lossy else index(rng), thin(rng)) for _ in range(rng.randint(1, most))]


def quarter_waves(wavelength_nm, indices):
    return [(n, wavelength_nm / 4 / n) for n in indices]


def ulps(x, count):
    for _ in range(abs(count)):
        x = math.nextafter(x, math.inf if count > 0 else 0)
    return x


# The classes of the reference.

def bare(rng):
    return {"n_first": index(rng), "n_last": rng.choice([index(rng), absorbing(rng), metal(rng)])}


def ar(rng):
    n, w = index(rng, 1.3, 2.4), wavelength(rng)
    coating = rng.choice([math.sqrt(n), 1.38, index(rng, 1.2, 2.4)])
    return {"n_last": n, "layers": quarter_waves(w, [coating, index(rng)][: rng.randint(1, 2)]),
            "wavelength_nm": w * rng.choice([1, 1, rng.uniform(0.7, 1.4)])}


def slab(rng):
    return {"n_last": AIR, "layers": [(index(rng), log(rng, 1, 1e5))]}


def morpho(rng):
    films = rng.randint(1, 12)
    pair_of = [(1.53, 50.0), (1.0, 150.0)]
    return {"n_last": AIR, "layers": (pair_of * films)[:-1], "wavelength_nm": float(rng.randint(350, 800))}


def hummingbird(rng):
    high, low, outer = rng.choice([(148.0, 98.0, 74.0), (74.0, 98.0, 37.0)])
    middle = [(2.0, high), (1.5, low)] * 7
    around = rng.choice([1.0, 1.5])
    return {"n_first": around, "n_last": around, "layers": [(2.0, outer), (1.5, low), *middle[:12], (2.0, outer)],
            "wavelength_nm": float(rng.randint(350, 1000))}


def random_stack(rng):
    return {"n_first": index(rng, 1, 2), "n_last": rng.choice([index(rng), absorbing(rng), metal(rng)]),
            "layers": random_layers(rng, 30)}


def metals(rng):
    layers = random_layers(rng, 4, 0.1)
    layers.insert(rng.randint(0, len(layers)), (metal(rng), log(rng, 1, 300)))
    return {"layers": layers, "n_last": rng.choice([GLASS, metal(rng)])}


def grazing(rng):
    last = rng.choice([1.0, GLASS, 1.0 + log(rng, 1e-12, 1e-2), absorbing(rng), index(rng)])
    layers = random_layers(rng, 5) if rng.random() < 0.7 else []
    return {"angle": cosine(log(rng, 1e-16, 1e-2)), "n_last": last, "layers": layers}


def grazing_degrees(rng):
    return {"angle": degrees(90 - log(rng, 1e-9, 1)), "n_last": index(rng), "layers": random_layers(rng, 4)}


def critical(rng):
    """kx a hair from the index of a layer or of the last medium."""
    first, n = rng.uniform(1.4, 2.5), rng.uniform(1.0, 1.35)
    away = rng.choice([-1, 1]) * log(rng, 1e-16, 1e-3)
    layers = random_layers(rng, 4)
    if rng.random() < 0.6:
        layers.insert(rng.randint(0, len(layers)), (n, log(rng, 1, 1000)))
        return {"n_first": first, "n_last": index(rng), "layers": layers, "angle": tangential(n * (1 + away))}
    return {"n_first": first, "n_last": n, "layers": layers if rng.random() < 0.6 else [],
            "angle": tangential(n * (1 + away))}


def ftir(rng):
    prism, gap = rng.uniform(1.45, 2.5), rng.choice([1.0, rng.uniform(1.0, 1.3)])
    sin = min(gap / prism * rng.uniform(1.001, 1.6), 0.9999)
    return {"n_first": prism, "n_last": rng.choice([prism, index(rng, gap, 2.5)]), "layers": [(gap, log(rng, 1, 3e5))],
            "angle": degrees(math.degrees(math.asin(sin)))}


def thick_absorber(rng):
    layers = random_layers(rng, 3) if rng.random() < 0.5 else []
    layers.append((complex(index(rng), log(rng, 1e-4, 8)), log(rng, 1e3, 1e6)))
    return {"layers": layers + (random_layers(rng, 2) if rng.random() < 0.5 else [])}


def thick_transparent(rng):
    layers = [(index(rng), log(rng, 1e5, 1e7)) for _ in range(rng.randint(1, 3))]
    layers += random_layers(rng, 3, 0) if rng.random() < 0.3 else []
    return {"n_last": rng.choice([AIR, GLASS]), "layers": layers}


def high_finesse(rng):
    w, high, low = wavelength(rng), rng.uniform(2, 3.5), rng.uniform(1.2, 1.5)
    mirror = quarter_waves(w, [high, low] * rng.randint(4, 14))
    spacer = (low, w / 2 / low * rng.randint(1, 4))
    detuned = 1 + rng.choice([0, 0, 1, -1]) * log(rng, 1e-15, 1e-6)
    around = rng.choice([AIR, GLASS])
    return {"n_first": around, "n_last": around, "layers": [*mirror, (high, mirror[0][1]), spacer, (high, mirror[0][1]),
            *mirror[::-1]], "wavelength_nm": w * detuned, "angle": degrees(0)}


def near_equal(rng):
    n = index(rng, 1, 2)
    close = lambda: n * (1 + rng.choice([-1, 1]) * log(rng, 1e-16, 1e-3))
    layers = [(close(), thin(rng)) for _ in range(rng.choice([0, 0, 1, 2, 5, 20]))]
    return {"n_first": n, "n_last": rng.choice([n, close()]), "layers": layers}


def near_equal_grazing(rng):
    out = near_equal(rng)
    return out | {"angle": rng.choice([cosine(log(rng, 1e-12, 1e-2)), degrees(90 - log(rng, 1e-6, 1))])}


def identical(rng):
    n = index(rng, 1, 2)
    return {"n_first": n, "n_last": n, "layers": [(n, log(rng, 1, 1e5)) for _ in range(rng.randint(0, 3))],
            "angle": rng.choice([angle(rng), cosine(log(rng, 1e-14, 1))])}


def zero_thickness(rng):
    layers = random_layers(rng, 4)
    nothing = lambda: (rng.choice([index(rng), absorbing(rng), metal(rng)]), rng.choice([0.0, log(rng, 1e-15, 1e-3)]))
    return {"layers": [x for layer in layers for x in (nothing(), layer)] if rng.random() < 0.7 else [nothing()],
            "n_last": index(rng)}


def brewster(rng):
    n = index(rng, 1.2, 3)
    deg = math.degrees(math.atan(n)) + rng.choice([0, 0, log(rng, 1e-14, 1e-2)])
    plates = rng.choice([0, 1, 2, 5, 20])
    d, gap = log(rng, 10, 1e6), log(rng, 10, 1e6)
    layers = [(n, d), (AIR, gap)] * plates
    return {"angle": degrees(deg), "n_last": AIR if plates else n, "layers": layers[:-1], "pol": rng.choice("ppps")}


def reciprocity(rng):
    first = index(rng, 1, 2)
    return {"n_first": first, "n_last": index(rng, 1, 2), "layers": random_layers(rng, 8),
            "angle": tangential(rng.uniform(0, min(first, 1.0)))}


def periodic(rng):
    """100 to 2000 layers that repeat: in the stop band, the pass band, at its edge, or weakly absorbing."""
    w, high, low = 550.0, rng.uniform(1.6, 2.5), rng.uniform(1.2, 1.5)
    high = complex(high, rng.choice([0, 0, log(rng, 1e-7, 1e-2)]))
    cell = [(high, w / 4 / high.real), (low, w / 4 / low)]
    w *= rng.choice([1, rng.uniform(0.6, 1.6)])
    return {"layers": cell, "repeat": rng.randint(50, 1000), "wavelength_nm": w}


def disordered(rng):
    """400 to 2000 layers, none like another."""
    spread, lossy = log(rng, 1e-3, 0.5), rng.choice([0, 0, 0.05])
    layers = [(complex(rng.uniform(1.4, 1.4 + spread), 1e-4 if rng.random() < lossy else 0), rng.uniform(20, 300))
              for _ in range(rng.randint(400, 2000))]
    return {"layers": layers}


# Nastier than the reference.

def tiny_k(rng):
    """Absorption so weak that it is nearly rounding."""
    weak = lambda: complex(index(rng), log(rng, 1e-18, 1e-9))
    return {"layers": [(weak(), log(rng, 10, 1e6)) for _ in range(rng.randint(0, 5))],
            "n_last": rng.choice([weak(), GLASS])}


def tiny_k_at_critical(rng):
    first, n = rng.uniform(1.4, 2.5), rng.uniform(1.0, 1.35)
    weak = complex(n, log(rng, 1e-18, 1e-4))
    out = {"n_first": first, "angle": tangential(rng.choice([n, ulps(n, rng.randint(-3, 3))]))}
    return out | rng.choice([{"n_last": weak}, {"layers": [(weak, log(rng, 1, 1e4))]}])


def complex_last(rng):
    last = rng.choice([absorbing(rng), metal(rng)])
    return {"n_first": index(rng, 1, 2.5), "layers": random_layers(rng, 8), "n_last": last,
            "angle": rng.choice([angle(rng), cosine(log(rng, 1e-9, 0.1))])}


def evanescent_last(rng):
    first, last = rng.uniform(1.4, 3), rng.uniform(0.05, 1.2)
    kx = rng.uniform(last, first)
    return {"n_first": first, "n_last": last, "layers": random_layers(rng, 8, rng.choice([0, 0.3])),
            "angle": rng.choice([tangential(kx), cosine(math.sqrt(1 - (kx / first) ** 2))])}


def kz_zero(rng):
    """kx equal to the index of one or more layers, to the last bit, or to that of the last medium."""
    first, n = rng.uniform(1.4, 2.5), rng.choice([1.0, 1.25, rng.uniform(1.0, 1.39)])
    layers = random_layers(rng, 5)
    for _ in range(rng.randint(1, 3)):
        layers.insert(rng.randint(0, len(layers)), (n, log(rng, 0.1, 1e5)))
    return {"n_first": first, "n_last": rng.choice([index(rng), n, 1.0]), "layers": rng.choice([layers, [(n, 100.0)]]),
            "angle": tangential(n)}


def kz_nearly_zero(rng):
    """The same, some units in the last place away."""
    out = kz_zero(rng)
    return out | {"angle": tangential(ulps(out["angle"]["value"], rng.choice([-4, -2, -1, 1, 2, 4])))}


def normal(rng):
    """Normal incidence, said in every way."""
    ways = [degrees(0), cosine(1), tangential(0), degrees(log(rng, 1e-300, 1e-5)), tangential(log(rng, 1e-300, 1e-5)),
            cosine(ulps(1.0, -rng.randint(1, 5)))]
    return {"angle": rng.choice(ways), "layers": random_layers(rng, 10), "n_last": rng.choice([GLASS, metal(rng)])}


def less_than_one(rng):
    """Media of index below 1, transparent and metallic."""
    below = lambda: complex(log(rng, 0.02, 1), rng.choice([0, 0, log(rng, 1e-6, 6)]))
    layers = [(rng.choice([below(), index(rng)]), log(rng, 1, 500)) for _ in range(rng.randint(0, 6))]
    return {"layers": layers, "n_last": rng.choice([below(), GLASS])}


def near_zero_index(rng):
    """Plasmas around their own frequency."""
    plasma = lambda: complex(rng.choice([0, log(rng, 1e-6, 0.1)]), log(rng, 1e-6, 0.5))
    layers = [(rng.choice([plasma(), index(rng)]), log(rng, 0.1, 500)) for _ in range(rng.randint(1, 4))]
    return {"layers": layers, "n_last": rng.choice([GLASS, plasma()])}


def pure_k(rng):
    """Index 0 and k > 0: total reflection without loss."""
    layers = random_layers(rng, 3, 0)
    layers.insert(rng.randint(0, len(layers)), (complex(0, log(rng, 0.1, 9)), log(rng, 0.1, 1000)))
    return {"layers": layers, "n_last": rng.choice([GLASS, complex(0, rng.uniform(0.1, 5))])}


def plasmon(rng):
    """Kretschmann and Otto: a prism, a metal, and light that runs along it."""
    eps = complex(-rng.uniform(5, 25), rng.choice([0, log(rng, 1e-9, 2)]))
    bound = (eps / (eps + 1)) ** 0.5
    kx = bound.real + rng.gauss(0, 3) * max(bound.imag, 1e-6)
    film, gap = (eps**0.5, rng.uniform(20, 120)), (AIR, rng.uniform(100, 3000))
    layers, last = rng.choice([([film], AIR), ([gap], eps**0.5), ([gap, film], AIR)])
    return {"n_first": 1.7, "layers": layers, "n_last": last, "angle": tangential(min(kx, 1.69)),
            "pol": rng.choice("ppps"), "wavelength_nm": 633.0}


def waveguide(rng):
    """A prism couples light through a gap into a guide, near and far from the resonance of a guided wave."""
    pol, n, kx = rng.choice("sp"), rng.uniform(1.5, 2.2), rng.uniform(1.02, 1.45)
    inside, outside = math.sqrt(n**2 - kx**2), math.sqrt(kx**2 - 1)
    mode = math.atan(outside / inside * (n**2 if pol == "p" else 1)) + rng.randint(0, 3) * math.pi / 2
    thickness = 550.0 / math.pi / inside * mode * (1 + rng.choice([0, 1, -1]) * log(rng, 1e-14, 1e-1))
    gap = (1.0, log(rng, 100, 1200))  # thicker: no double hits the resonance
    return {"n_first": 2.5, "layers": [gap, (n, thickness), gap], "n_last": rng.choice([2.5, 1.0, 1.0]),
            "angle": tangential(kx), "pol": pol, "wavelength_nm": 550.0}


def tunnels(rng):
    """Travelling and evanescent layers by turns: fields far above the flux they carry."""
    layers = [(rng.choice([1.0, 1.2, 2.0, 2.4]), log(rng, 10, 3000)) for _ in range(rng.randint(3, 20))]
    return {"n_first": 2.5, "n_last": rng.choice([2.5, 1.0, 1.4]), "layers": layers,
            "angle": tangential(rng.uniform(0.9, 2.45))}


def high_contrast(rng):
    layers = [(rng.choice([20.0, 0.05, 1.0, 10.0, complex(10, 10), complex(0.01, 10)]), log(rng, 0.01, 1000))
              for _ in range(rng.randint(1, 8))]
    return {"layers": layers, "n_last": rng.choice([20.0, 1.0, complex(20, 20)])}


def long_waves(rng):
    """Thin beyond reason, or wavelengths of a metre."""
    layers = [(n, d * log(rng, 1e-12, 1)) for n, d in random_layers(rng, 6)]
    return {"layers": layers, "wavelength_nm": log(rng, 100, 1e9), "n_last": rng.choice([AIR, GLASS, metal(rng)])}


def utterly_grazing(rng):
    """cos θ far below what 1 - sin² can hold, 0 too."""
    last = rng.choice([1.5, ulps(1.0, rng.randint(1, 9)), absorbing(rng), 0.9])
    layers = random_layers(rng, 4) if rng.random() < 0.6 else []
    grazing = rng.choice([cosine(log(rng, 1e-140, 1e-10)), cosine(0), degrees(90)])
    return {"angle": grazing, "n_last": last, "layers": layers}


def opaque(rng):
    """Transmission around and below the smallest double."""
    k = rng.uniform(0.5, 5)
    decades = rng.uniform(280, 340)
    d = decades * math.log(10) * 550.0 / (2 * math.pi * k)
    return {"layers": [(index(rng), thin(rng)), (complex(1.5, k), d)], "wavelength_nm": 550.0, "angle": degrees(0)}


def between_absorbers(rng):
    """A weak layer between strong ones, in which reflections of the far side drown."""
    strong = (complex(index(rng), rng.uniform(0.5, 5)), log(rng, 100, 1e4))
    return {"layers": [strong, *random_layers(rng, 3), strong, *random_layers(rng, 3)]}


CLASSES = [bare, ar, slab, morpho, hummingbird, random_stack, metals, grazing, grazing_degrees, critical, ftir,
           thick_absorber, thick_transparent, high_finesse, near_equal, near_equal_grazing, identical, zero_thickness,
           brewster, reciprocity, periodic, tiny_k, tiny_k_at_critical, complex_last, evanescent_last, kz_zero,
           kz_nearly_zero, normal, less_than_one, near_zero_index, pure_k, plasmon, waveguide, tunnels, high_contrast,
           long_waves, utterly_grazing, opaque, between_absorbers, disordered]
