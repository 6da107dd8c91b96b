// No code: the source of the target that precompiles GoogleTest's headers for all others.
