void main() { leaveHolesOut(); }
