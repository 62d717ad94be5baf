"""What a store of a sweep holds, for tests that compare two of them byte by byte."""


def contents(store):
    """Bytes of every file of a store."""
    files = sorted(path for path in store.rglob("*") if path.is_file())
    return {str(path.relative_to(store)): path.read_bytes() for path in files}
