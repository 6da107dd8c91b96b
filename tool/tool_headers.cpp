// No code: the source of the target that precompiles the headers of options and JSON for the tools.
