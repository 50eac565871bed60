"""The paper's studies: its tables as data, and their runners."""
