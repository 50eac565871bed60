"""Topics of any file into recordings, through a topic map."""
