"""Tables for notebooks; the one import of pandas."""

from collections.abc import Mapping
from typing import Any

from orbident.extras import extra


def frame(columns: Mapping[str, Any], index: Any, name: str) -> Any:
    """A `pandas.DataFrame`.

    Args:
        columns: by name; each as long as the index.
        index: what names the rows.
        name: of the index.

    Raises:
        MissingLibraryError: pandas is not installed.
    """
    with extra("pandas", "to_frame()"):
        import pandas as pd
    return pd.DataFrame(dict(columns), index=pd.Index(index, name=name))
