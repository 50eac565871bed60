"""Where the methods come from. Data only."""

THE_PAPER = (
    "On the parameter identification of free-flying space manipulator systems: "
    "momentum (Eqs. 17-26), velocity (Eqs. 27-31), mass (Eqs. 32-42)"
)

_LINEAR = (
    "G. Golub, Numerical methods for solving linear least squares problems, "
    "Numerische Mathematik 7, 1965",
    "W. Khalil, E. Dombre, Modeling, Identification and Control of Robots, 2002 "
    "(minimal sets)",
)

_MOST_LIKELY = (
    "R. Maine, K. Iliff, Identification of Dynamic Systems: Theory and Formulation, "
    "NASA RP-1138, 1985 (output error)",
    "H. G. Bock, Recent advances in parameter identification techniques for ODE, 1983 "
    "(multiple shooting)",
    "D. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, "
    "SIAM Journal on Applied Mathematics 11, 1963",
    "G. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977",
    "P. Huber, Robust estimation of a location parameter, Annals of Mathematical "
    "Statistics 35, 1964 (outliers)",
)

BY_METHOD = {
    "least-squares": _LINEAR,
    "structured": (*_LINEAR, _MOST_LIKELY[2]),
    "maximum-likelihood": (*_LINEAR, *_MOST_LIKELY),
    "recursive": (
        *_LINEAR,
        _MOST_LIKELY[3],
        "A. Willsky, H. Jones, A generalized likelihood ratio approach to the "
        "detection and estimation of jumps in linear systems, IEEE Transactions on "
        "Automatic Control 21, 1976",
        "M. Basseville, I. Nikiforov, Detection of Abrupt Changes, 1993",
    ),
}

SMOOTHING = (
    "G. Wahba, Improper priors, spline smoothing and the problem of guarding against "
    "model errors in regression, Journal of the Royal Statistical Society B 40, 1978"
)

SPECTRA = (
    "P. Welch, The use of fast Fourier transform for the estimation of power spectra, "
    "IEEE Transactions on Audio and Electroacoustics 15, 1967"
)
