"""A small OpenFAST deck with ROSCO's files, written here: uniform blades and a uniform tower."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from takagi.models.files.csv_table import read_coefficient_table

DATA = Path(__file__).parents[3] / "models" / "data"
TIP, HUB, CONE, DENSITY = 63.0, 1.5, -2.5, 280.0
HEIGHT, TOWER_DENSITY, BENDING = 87.6, 4000.0, 3e11
HUB_MASS, NACELLE = 56780.0, 240000.0

FST = """
9.80665   Gravity   - Gravitational acceleration (m/s^2)
1.225     AirDens   - Air density (kg/m^3)
"elasto.dat"   EDFile    - ElastoDyn input (quoted string)
"servo.dat"    ServoFile - ServoDyn input (quoted string)
"""
ELASTODYN = f"""
3          NumBl       - Number of blades (-)
{TIP}      TipRad      - rotor apex to blade tip (meters)
{HUB}      HubRad      - rotor apex to blade root (meters)
{CONE}     PreCone(1)  - Blade 1 cone angle (degrees)
-5.0191    OverHang    - yaw axis to rotor apex (meters)
-5         ShftTilt    - Rotor shaft tilt angle (degrees)
1.96256    Twr2Shft    - tower-top to the rotor shaft (meters)
{HEIGHT}   TowerHt     - Height of tower (meters)
0          TowerBsHt   - Height of tower base (meters)
{HUB_MASS} HubMass     - Hub mass (kg)
115926     HubIner     - Hub inertia about rotor axis (kg m^2)
534.116    GenIner     - Generator inertia about HSS (kg m^2)
{NACELLE}  NacMass     - Nacelle mass (kg)
0          YawBrMass   - Yaw bearing mass (kg)
"blade.dat"  BldFile(1)  - blade 1 (quoted string)
97         GBRatio     - Gearbox ratio (-)
8.67637E+08 DTTorSpr   - Drivetrain torsional spring (N-m/rad)
6.215E+06  DTTorDmp    - Drivetrain torsional damper (N-m/(rad/s))
"tower.dat"  TwrFile    - tower properties (quoted string)
"""
SERVODYN = """
94.4       GenEff      - Generator efficiency (%)
9999.9     VS_RtGnSp   - Rated generator speed (rpm) [used only when VSContrl=1]
9999.9     VS_RtTq     - Rated generator torque (N-m) [used only when VSContrl=1]
"DISCON.IN" DLL_InFile - Name of input file sent to the DLL (-)
"""
BLADE = f"""
1.05       AdjBlMs     - Factor to adjust blade mass density (-)
BlFract  StrcTwst  BMassDen
  (-)      (deg)    (kg/m)
{chr(10).join(f"{x:.4f}  0.0  {DENSITY}" for x in np.linspace(0, 1, 201))}
---- BLADE MODE SHAPES ----
"""
TOWER = f"""
1          TwrFADmp(1) - 1st fore-aft mode structural damping ratio (%)
1          FAStTunr(1) - stiffness tuner, 1st mode (-)
1          AdjTwMa     - tower mass density (-)
1          AdjFASt     - fore-aft stiffness (-)
HtFract  TMassDen  TwFAStif  TwSSStif
  (-)     (kg/m)    (Nm^2)    (Nm^2)
0.0  {TOWER_DENSITY}  {BENDING}  {BENDING}
1.0  {TOWER_DENSITY}  {BENDING}  {BENDING}
---- MODE SHAPES ----
2.0   TwFAM1Sh(2) - Mode 1, coefficient of x^2 term
0.0   TwFAM1Sh(3) -       , coefficient of x^3 term
0.0   TwFAM1Sh(4) -       , coefficient of x^4 term
0.0   TwFAM1Sh(5) -       , coefficient of x^5 term
0.0   TwFAM1Sh(6) -       , coefficient of x^6 term
"""
DISCON = """! Controller parameter input file
1.57080         ! F_LPFCornerFreq - Corner frequency [rad/s]
1.570000000000  ! PC_MaxPit  - Maximum physical pitch limit, [rad].
0.174500000000  ! PC_MaxRat  - Maximum pitch rate [rad/s].
122.9096700000  ! PC_RefSpd  - Desired (reference) HSS speed [rad/s].
0.000000000000  ! PC_FinePit - Below-rated pitch angle set-point, [rad]
94.40000        ! VS_GenEff  - Generator efficiency [%]
4.00000e+04     ! VS_MaxRat  - Maximum torque rate [Nm/s].
4.74029e+04     ! VS_MaxTq   - Maximum generator torque [Nm].
70.16224        ! VS_MinOMSpd - Minimum generator speed [rad/s]
4.30935e+04     ! VS_RtTq    - Rated torque, [Nm].
43702538.05700  ! WE_Jtot    - Total drivetrain inertia [kg m^2]
3.000  10.0  25.000  ! WE_FOPoles_v - Wind speeds [m/s]
"Cp_Ct_Cq.small.txt" ! PerfFileName - File containing rotor performance tables
"""
TUNING = """
path_params:
  FAST_InputFile: 'small.fst'     # Name of *.fst file
  FAST_directory: 'deck'          # Main OpenFAST model directory
turbine_params: {rotor_inertia: 38677040.613, rated_rotor_speed: 1.26711, v_min: 3.0, v_max: 25.0}
controller_params:
  vs_minspd: 0.72                 # Minimum rotor speed [rad/s]
  # v_min: 99.0                   a comment
"""


def table_text() -> str:
    """Return the tables of the NREL 5-MW turbine in ROSCO's form."""
    tables = [read_coefficient_table(DATA / f"nrel5mw_c{letter}.csv") for letter in "pt"]
    first = tables[0]

    def row(numbers: np.ndarray) -> str:
        return "   ".join(f"{number:.6f}" for number in numbers)

    blocks = [
        f"# {word} coefficient\n\n" + "\n".join(map(row, table.values))
        for word, table in zip(("Power", " Thrust", "Torque"), [*tables, first], strict=True)
    ]
    return "\n".join(
        [
            "# ----- Rotor performance tables -----\n",
            f"# Pitch angle vector, {len(first.pitch)} entries - x axis (deg)",
            row(np.degrees(first.pitch)),
            "# TSR vector - y axis (matrix rows) (-)",
            row(first.tip_speed_ratio),
            "# Wind speed vector - z axis (m/s)\n11.4\n",
            *blocks,
        ]
    )


def written_deck(folder: Path, **texts: str) -> Path:
    """A text given by the name of a file's constant, in lower case, stands in its place."""
    files = {
        "small.fst": texts.get("fst", FST),
        "elasto.dat": texts.get("elastodyn", ELASTODYN),
        "servo.dat": texts.get("servodyn", SERVODYN),
        "blade.dat": texts.get("blade", BLADE),
        "tower.dat": texts.get("tower", TOWER),
        "DISCON.IN": texts.get("discon", DISCON),
        "Cp_Ct_Cq.small.txt": texts.get("table", table_text()),
    }
    deck = folder / "deck"
    deck.mkdir()
    for name, text in files.items():
        if text:
            (deck / name).write_text(text, encoding="utf-8")
    (folder / "tuning.yaml").write_text(texts.get("tuning", TUNING), encoding="utf-8")
    return deck
