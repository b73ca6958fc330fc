"""`python -m vrcomfort`: the same as the command `vrcomfort`."""

from vrcomfort.cli import main

if __name__ == "__main__":
    main()
