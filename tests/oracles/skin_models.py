"""Every skin model once more, from its equations, in mpmath, band by band."""

from mpmath import mp, mpf

from oracles import kubelka_munk as km


def body(name, values, at, D, hypodermis=1.0):
    """Return R_b of named values; ``at`` has K_m, K_h, K_dh, S_e, S_d and nm."""
    v = {key: mpf(value) for key, value in values.items()}
    at = {key: mpf(float(value)) for key, value in at.items()}
    D_e, D_d = (mpf(d) for d in D)
    blood = v["w_h"] * at["K_h"] + v["w_dh"] * at["K_dh"]
    melanin = v["w_m"] * at["K_m"]
    if name == "lambert-beer":
        return hypodermis * mp.exp(-(melanin * D_e + blood * D_d + v["offset"]))
    if name == "cotton":
        tissue = 2 * (
            mpf("0.0244") + mpf("8.53") * mp.exp(-(at["nm"] - 154) / mpf("66.2"))
        )
        dermis = km.layer(blood + tissue, at["S_d"], D_d)
        return mp.exp(-melanin * D_e) * km.over(dermis, mpf(hypodermis))
    share = v.get("scattering", mpf(1))
    fall = (at["nm"] / 500) ** -v.get("melanin_slope", mpf(0))
    return km.stack(
        (melanin * fall, blood),
        (share * at["S_e"], share * at["S_d"]),
        (D_e * v.get("epidermis", mpf(1)), D_d),
        hypodermis,
    )
