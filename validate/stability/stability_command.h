// nlg-validate stability: every stiff and extreme case with what must hold and what was measured, as one JSON file.
#pragma once

namespace nlg {

// returns   the exit code: check_failed, after the file is written, when some case did not hold
int stabilityMain(int argc, char** argv);

}  // namespace nlg
