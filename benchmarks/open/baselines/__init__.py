"""Other methods, as plain as they can be written."""
