"""``python -m friction_audit``."""

from friction_audit.cli import main

if __name__ == "__main__":
    main()
