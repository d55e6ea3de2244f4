"""The explicit Runge-Kutta pair of order 8(5,3) by Dormand and Prince, with its dense output of order 7.

Coefficients as in Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I", 2nd ed., section II.10, and
the program DOP853 that goes with it: A stage sums, B solution, E and G error estimates of order 5 and 3, D dense
output.  Time is a component of the state here, so the nodes of the stages are not needed.
"""

import math

import numpy as np

from ..compiled.choosing import where
from ..compiled.dual import as_type_of
from ..compiled.family import inlined, kernel

A2_1 = 0.05260015195876773
A3_1 = 0.0197250569845379
A3_2 = 0.0591751709536137
A4_1 = 0.02958758547680685
A4_3 = 0.08876275643042054
A5_1 = 0.2413651341592667
A5_3 = -0.8845494793282861
A5_4 = 0.924834003261792
A6_1 = 0.037037037037037035
A6_4 = 0.17082860872947386
A6_5 = 0.12546768756682242
A7_1 = 0.037109375
A7_4 = 0.17025221101954405
A7_5 = 0.06021653898045596
A7_6 = -0.017578125
A8_1 = 0.03709200011850479
A8_4 = 0.17038392571223998
A8_5 = 0.10726203044637328
A8_6 = -0.015319437748624402
A8_7 = 0.008273789163814023
A9_1 = 0.6241109587160757
A9_4 = -3.3608926294469414
A9_5 = -0.868219346841726
A9_6 = 27.59209969944671
A9_7 = 20.154067550477894
A9_8 = -43.48988418106996
A10_1 = 0.47766253643826434
A10_4 = -2.4881146199716677
A10_5 = -0.590290826836843
A10_6 = 21.230051448181193
A10_7 = 15.279233632882423
A10_8 = -33.28821096898486
A10_9 = -0.020331201708508627
A11_1 = -0.9371424300859873
A11_4 = 5.186372428844064
A11_5 = 1.0914373489967295
A11_6 = -8.149787010746927
A11_7 = -18.52006565999696
A11_8 = 22.739487099350505
A11_9 = 2.4936055526796523
A11_10 = -3.0467644718982196
A12_1 = 2.273310147516538
A12_4 = -10.53449546673725
A12_5 = -2.0008720582248625
A12_6 = -17.9589318631188
A12_7 = 27.94888452941996
A12_8 = -2.8589982771350235
A12_9 = -8.87285693353063
A12_10 = 12.360567175794303
A12_11 = 0.6433927460157636
A14_1 = 0.056167502283047954
A14_7 = 0.25350021021662483
A14_8 = -0.2462390374708025
A14_9 = -0.12419142326381637
A14_10 = 0.15329179827876568
A14_11 = 0.00820105229563469
A14_12 = 0.007567897660545699
A14_13 = -0.008298
A15_1 = 0.03183464816350214
A15_6 = 0.028300909672366776
A15_7 = 0.053541988307438566
A15_8 = -0.05492374857139099
A15_11 = -0.00010834732869724932
A15_12 = 0.0003825710908356584
A15_13 = -0.00034046500868740456
A15_14 = 0.1413124436746325
A16_1 = -0.42889630158379194
A16_6 = -4.697621415361164
A16_7 = 7.683421196062599
A16_8 = 4.06898981839711
A16_9 = 0.3567271874552811
A16_13 = -0.0013990241651590145
A16_14 = 2.9475147891527724
A16_15 = -9.15095847217987
B1 = 0.054293734116568765
B6 = 4.450312892752409
B7 = 1.8915178993145003
B8 = -5.801203960010585
B9 = 0.3111643669578199
B10 = -0.1521609496625161
B11 = 0.20136540080403034
B12 = 0.04471061572777259
G1 = -0.18980075407240762
G6 = 4.450312892752409
G7 = 1.8915178993145003
G8 = -5.801203960010585
G9 = -0.4226823213237919
G10 = -0.1521609496625161
G11 = 0.20136540080403034
G12 = 0.02265179219836082
E1 = 0.01312004499419488
E6 = -1.2251564463762044
E7 = -0.4957589496572502
E8 = 1.6643771824549864
E9 = -0.35032884874997366
E10 = 0.3341791187130175
E11 = 0.08192320648511571
E12 = -0.022355307863886294
D4_1 = -8.428938276109013
D4_6 = 0.5667149535193777
D4_7 = -3.0689499459498917
D4_8 = 2.38466765651207
D4_9 = 2.117034582445028
D4_10 = -0.871391583777973
D4_11 = 2.2404374302607883
D4_12 = 0.6315787787694688
D4_13 = -0.08899033645133331
D4_14 = 18.148505520854727
D4_15 = -9.194632392478356
D4_16 = -4.436036387594894
D5_1 = 10.427508642579134
D5_6 = 242.28349177525817
D5_7 = 165.20045171727028
D5_8 = -374.5467547226902
D5_9 = -22.113666853125306
D5_10 = 7.733432668472264
D5_11 = -30.674084731089398
D5_12 = -9.332130526430229
D5_13 = 15.697238121770845
D5_14 = -31.139403219565178
D5_15 = -9.35292435884448
D5_16 = 35.81684148639408
D6_1 = 19.985053242002433
D6_6 = -387.0373087493518
D6_7 = -189.17813819516758
D6_8 = 527.8081592054236
D6_9 = -11.57390253995963
D6_10 = 6.8812326946963
D6_11 = -1.0006050966910838
D6_12 = 0.7777137798053443
D6_13 = -2.778205752353508
D6_14 = -60.19669523126412
D6_15 = 84.32040550667716
D6_16 = 11.99229113618279
D7_1 = -25.69393346270375
D7_6 = -154.18974869023643
D7_7 = -231.5293791760455
D7_8 = 357.6391179106141
D7_9 = 93.40532418362432
D7_10 = -37.45832313645163
D7_11 = 104.0996495089623
D7_12 = 29.8402934266605
D7_13 = -43.53345659001114
D7_14 = 96.32455395918828
D7_15 = -39.17726167561544
D7_16 = -149.72683625798564

# Rows of k: 0 to 11 the stages of a step, END the rates at its end, up to ROWS those that the dense output adds.
END, SCRATCH, ROWS = 12, 15, 16  # SCRATCH is free again once the coefficients of the dense output are made
# fmt: off
NODE_SHARES = np.array([0.0, 0.0526, 0.0789, 0.11835034190722739, 0.28164965809277260, 1.0 / 3.0, 0.25,
                        0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0, 1.0])
# fmt: on
WEIGHTS = np.array([B1, 0.0, 0.0, 0.0, 0.0, B6, B7, B8, B9, B10, B11, B12])


# fmt: off
@inlined
def stage_state(row, h, y, k, w):
    """Put into `w` the state at which row `row` of `k` is to be evaluated, for a step of length `h` from `y`.

    y, w : (n,); k : (16, n), rows below `row` filled.  Row 12 is the end of the step (II.10.20 with the weights B).
    """
    if row == 1:
        for i in range(y.size):
            w[i] = y[i] + h * (A2_1 * k[0, i])
    elif row == 2:
        for i in range(y.size):
            w[i] = y[i] + h * (A3_1 * k[0, i] + A3_2 * k[1, i])
    elif row == 3:
        for i in range(y.size):
            w[i] = y[i] + h * (A4_1 * k[0, i] + A4_3 * k[2, i])
    elif row == 4:
        for i in range(y.size):
            w[i] = y[i] + h * (A5_1 * k[0, i] + A5_3 * k[2, i] + A5_4 * k[3, i])
    elif row == 5:
        for i in range(y.size):
            w[i] = y[i] + h * (A6_1 * k[0, i] + A6_4 * k[3, i] + A6_5 * k[4, i])
    elif row == 6:
        for i in range(y.size):
            w[i] = y[i] + h * (A7_1 * k[0, i] + A7_4 * k[3, i] + A7_5 * k[4, i] + A7_6 * k[5, i])
    elif row == 7:
        for i in range(y.size):
            w[i] = y[i] + h * (A8_1 * k[0, i] + A8_4 * k[3, i] + A8_5 * k[4, i] + A8_6 * k[5, i] + A8_7 * k[6, i])
    elif row == 8:
        for i in range(y.size):
            w[i] = y[i] + h * (A9_1 * k[0, i] + A9_4 * k[3, i] + A9_5 * k[4, i] + A9_6 * k[5, i] + A9_7 * k[6, i]
                    + A9_8 * k[7, i])
    elif row == 9:
        for i in range(y.size):
            w[i] = y[i] + h * (A10_1 * k[0, i] + A10_4 * k[3, i] + A10_5 * k[4, i] + A10_6 * k[5, i]
                    + A10_7 * k[6, i] + A10_8 * k[7, i] + A10_9 * k[8, i])
    elif row == 10:
        for i in range(y.size):
            w[i] = y[i] + h * (A11_1 * k[0, i] + A11_4 * k[3, i] + A11_5 * k[4, i] + A11_6 * k[5, i]
                    + A11_7 * k[6, i] + A11_8 * k[7, i] + A11_9 * k[8, i] + A11_10 * k[9, i])
    elif row == 11:
        for i in range(y.size):
            w[i] = y[i] + h * (A12_1 * k[0, i] + A12_4 * k[3, i] + A12_5 * k[4, i] + A12_6 * k[5, i]
                    + A12_7 * k[6, i] + A12_8 * k[7, i] + A12_9 * k[8, i] + A12_10 * k[9, i] + A12_11 * k[10, i])
    elif row == 12:
        for i in range(y.size):
            w[i] = y[i] + h * (B1 * k[0, i] + B6 * k[5, i] + B7 * k[6, i] + B8 * k[7, i] + B9 * k[8, i]
                    + B10 * k[9, i] + B11 * k[10, i] + B12 * k[11, i])
    elif row == 13:
        for i in range(y.size):
            w[i] = y[i] + h * (A14_1 * k[0, i] + A14_7 * k[6, i] + A14_8 * k[7, i] + A14_9 * k[8, i]
                    + A14_10 * k[9, i] + A14_11 * k[10, i] + A14_12 * k[11, i] + A14_13 * k[12, i])
    elif row == 14:
        for i in range(y.size):
            w[i] = y[i] + h * (A15_1 * k[0, i] + A15_6 * k[5, i] + A15_7 * k[6, i] + A15_8 * k[7, i]
                    + A15_11 * k[10, i] + A15_12 * k[11, i] + A15_13 * k[12, i] + A15_14 * k[13, i])
    elif row == 15:
        for i in range(y.size):
            w[i] = y[i] + h * (A16_1 * k[0, i] + A16_6 * k[5, i] + A16_7 * k[6, i] + A16_8 * k[7, i]
                    + A16_9 * k[8, i] + A16_13 * k[12, i] + A16_14 * k[13, i] + A16_15 * k[14, i])


HUGE = 1e300


@inlined
def error_norm(h, k, weight):
    """Return the error of a step of length `h` over the tolerance: the step is good below 1.

    k : (16, n), rows 0 to 11 filled; weight : (n,) 1 / allowed error of each component.  Root mean square of the fifth
    order estimate, damped by the third order one (II.10.16 ff. and DOP853).
    """
    fifth = third = as_type_of(0.0, weight[0])
    for i in range(weight.size):
        e5 = (E1 * k[0, i] + E6 * k[5, i] + E7 * k[6, i] + E8 * k[7, i] + E9 * k[8, i] + E10 * k[9, i]
              + E11 * k[10, i] + E12 * k[11, i]) * weight[i]
        e3 = (G1 * k[0, i] + G6 * k[5, i] + G7 * k[6, i] + G8 * k[7, i] + G9 * k[8, i] + G10 * k[9, i]
              + G11 * k[10, i] + G12 * k[11, i]) * weight[i]
        fifth, third = fifth + e5 * e5, third + e3 * e3
    finite = fifth + third < HUGE  # also where a stage was not: an infinite third alone would look like no error
    size = where(finite & (fifth != 0.0), math.sqrt((fifth + 0.01 * third) * weight.size), 1.0)
    return where(finite, abs(h) * fifth / size, math.inf)


@kernel
def dense_coefficients(h, y, end, k, f):
    """Put into `f` (7, n) the coefficients of the interpolant over the step of length `h` from `y` to `end`.

    All 16 rows of `k` are filled.  Section II.6, equation (6.20 ff.), coefficients D of DOP853.
    """
    for i in range(y.size):
        rise = end[i] - y[i]
        f[0, i] = rise
        f[1, i] = h * k[0, i] - rise
        f[2, i] = 2.0 * rise - h * (k[12, i] + k[0, i])
        f[3, i] = h * (D4_1 * k[0, i] + D4_6 * k[5, i] + D4_7 * k[6, i] + D4_8 * k[7, i] + D4_9 * k[8, i]
                  + D4_10 * k[9, i] + D4_11 * k[10, i] + D4_12 * k[11, i] + D4_13 * k[12, i] + D4_14 * k[13, i]
                  + D4_15 * k[14, i] + D4_16 * k[15, i])
        f[4, i] = h * (D5_1 * k[0, i] + D5_6 * k[5, i] + D5_7 * k[6, i] + D5_8 * k[7, i] + D5_9 * k[8, i]
                  + D5_10 * k[9, i] + D5_11 * k[10, i] + D5_12 * k[11, i] + D5_13 * k[12, i] + D5_14 * k[13, i]
                  + D5_15 * k[14, i] + D5_16 * k[15, i])
        f[5, i] = h * (D6_1 * k[0, i] + D6_6 * k[5, i] + D6_7 * k[6, i] + D6_8 * k[7, i] + D6_9 * k[8, i]
                  + D6_10 * k[9, i] + D6_11 * k[10, i] + D6_12 * k[11, i] + D6_13 * k[12, i] + D6_14 * k[13, i]
                  + D6_15 * k[14, i] + D6_16 * k[15, i])
        f[6, i] = h * (D7_1 * k[0, i] + D7_6 * k[5, i] + D7_7 * k[6, i] + D7_8 * k[7, i] + D7_9 * k[8, i]
                  + D7_10 * k[9, i] + D7_11 * k[10, i] + D7_12 * k[11, i] + D7_13 * k[12, i] + D7_14 * k[13, i]
                  + D7_15 * k[14, i] + D7_16 * k[15, i])


# fmt: on
@kernel
def dense_component(x, i, y, f):
    """Return component `i` of the interpolant at the share `x` (0 to 1) of the step that starts at `y`."""
    r = 1.0 - x
    inner = f[3, i] + x * (f[4, i] + r * (f[5, i] + x * f[6, i]))
    return y[i] + x * (f[0, i] + r * (f[1, i] + x * (f[2, i] + r * inner)))


def shapes(x):
    """Return the (places, 7) values at the shares `x` of what the rows of `f` are multiplied by."""
    r = 1.0 - x
    return np.stack([x, x * r, x**2 * r, (x * r) ** 2, x**3 * r**2, (x * r) ** 3, x**4 * r**3], axis=1)


@kernel
def dense_state(x, y, f, w):
    """Put into `w` (n,) the interpolant at the share `x` (0 to 1) of the step that starts at `y` (n,)."""
    for i in range(y.size):
        w[i] = dense_component(x, i, y, f)
