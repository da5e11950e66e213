def main(log, config, output, inside):
    return 1
