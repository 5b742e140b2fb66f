"""What the program does with damaged and hostile files: it answers, refuses or leaves out, and never fails silently."""
