"""The standard contract: what each role gives. Written by `poretwin exchange-fields --python`."""

# name, unit, vector, conservative, mask
STANDARD: dict[str, list[tuple[str, str, bool, bool, str]]] = {
    "fluid": [
        ("pore_pressure", "Pa", False, False, ""),
        ("predicted_solid_velocity", "m/s", True, False, "soil_fraction"),
        ("predicted_change", "m/s", True, False, "soil_fraction"),
        ("drag_impulse", "N s", True, True, ""),
        ("soil_fraction", "1", False, False, ""),
        ("surface_gradient", "Pa/m", True, False, "surface_share"),
        ("surface_share", "1", False, False, ""),
    ],
    "solid": [
        ("solid_velocity", "m/s", True, False, ""),
        ("mean_solid_velocity", "m/s", True, False, ""),
        ("volumetric_strain_rate", "1/s", False, False, ""),
        ("unbalanced_force", "N/m3", True, False, ""),
        ("solid_volume_fraction", "1", False, False, ""),
        ("grain_density", "kg/m3", False, False, ""),
        ("constrained_modulus", "Pa", False, False, ""),
        ("yielding", "1", False, False, ""),
        ("hydraulic_conductivity", "m/s", False, False, ""),
        ("forchheimer_coefficient", "s2/m2", False, False, ""),
        ("returned_impulse", "N s", True, True, ""),
    ],
}
