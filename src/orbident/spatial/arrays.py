"""The arrays that the numerical core takes and gives: JAX's, or NumPy's going in."""

import jax
import numpy as np

AnyArray = jax.Array | np.ndarray
