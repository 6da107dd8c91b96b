// The command nlg-validate stability: runs every stiff and extreme case, and writes one JSON file.
#pragma once

namespace nlg {

// returns   the exit code: check_failed, after the file is written, when some case did not hold
int stabilityMain(int argc, char** argv);

}  // namespace nlg
