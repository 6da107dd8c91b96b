def cases(siege, count):
    return iter(())
