"""The baselines as OSL functions of two unit vectors in a frame whose z axis is the normal; their first channel."""

from math import factorial

import numpy as np

from .report.baselines.koenderink import modes


def koenderink(model):
    """OSL source of `float koenderink(vector wi, vector wo)`; R_n^l by Horner's rule, cos(l phi) by recurrence."""
    order, body = model.order, []
    for side in "io":
        body += [f"float t_{side} = 1.0 - w{side}[2];", f"float r_{side}_1 = sqrt(max(t_{side}, 0.0));",
                 f"float r_{side}_0 = 1.0;"]
        body += [f"float r_{side}_{l} = r_{side}_{l - 1} * r_{side}_1;" for l in range(2, order + 1)]
        body += [f"float R_{side}_{n}_{l} = r_{side}_{l} * ({_horner(n, l, f't_{side}')});"
                 for n, l in sorted({(n, l) for n, _, l in modes(order)})]
    body += ["float s = hypot(wi[0], wi[1]) * hypot(wo[0], wo[1]);",
             "float c_1 = s > 0.0 ? (wi[0] * wo[0] + wi[1] * wo[1]) / s : 1.0;", "float c_0 = 1.0;"]
    body += [f"float c_{l} = 2.0 * c_1 * c_{l - 1} - c_{l - 2};" for l in range(2, order + 1)]
    terms = [f"{a:.9g} * (R_i_{n}_{l} * R_o_{m}_{l} + R_i_{m}_{l} * R_o_{n}_{l}) * c_{l}"
             for (n, m, l), a in zip(modes(order), model.coefficients[:, 0], strict=True)]
    return _function("koenderink", body, terms)


def lafortune(model):
    """OSL source of `float lafortune(vector wi, vector wo)`."""
    body = ["float xy = wi[0] * wo[0] + wi[1] * wo[1];", "float z = wi[2] * wo[2];"]
    terms = [f"{model.rho[0] / 3.141592653589793:.9g}"]
    terms += [f"pow(max({c_xy:.9g} * xy + {c_z:.9g} * z, 0.0), {n:.9g})" for c_xy, c_z, n in model.lobes[:, :, 0]]
    largest = float(np.ravel(model.ceiling)[0])
    return _function("lafortune", body, terms, f"clamp(%s, 0.0, {largest:.8e})")


def _horner(n, l, t):
    """R_n^l(r) / r^l as a polynomial in t = r^2."""
    half = (n - l) // 2
    coefficients = [(-1) ** k * factorial(n - k) // (factorial(k) * factorial((n + l) // 2 - k) * factorial(half - k))
                    for k in range(half + 1)]
    text = f"{coefficients[0]}.0"
    for coefficient in coefficients[1:]:
        text = f"({text}) * {t} + {coefficient}.0"
    return text


def _function(name, body, terms, of_sum="%s"):
    lines, total = "\n  ".join(body), "\n    + ".join(terms)
    return f"float {name}(vector wi, vector wo)\n{{\n  {lines}\n  return {of_sum % total};\n}}\n"
