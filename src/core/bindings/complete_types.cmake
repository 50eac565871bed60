# An array of any element type is NDArray[Any] to type checkers; bare, it is of unknown type.
file(READ ${STUB} text)
string(REPLACE "Annotated[NDArray," "Annotated[NDArray[Any]," text "${text}")
string(REPLACE "import Annotated\n" "import Annotated, Any\n" text "${text}")
file(WRITE ${STUB} "${text}")
