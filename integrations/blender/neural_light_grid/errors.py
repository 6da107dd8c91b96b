"""What ends an operator, in one sentence for whoever called it: mostly the tool's own."""


class ToolError(Exception):
    pass
