"""Files of other tools, each read as tables: a name, fields, their values."""
