// nlg-validate compare OLD NEW: says what got better or worse, and gates a build by its exit code.
#pragma once

namespace nlg {

// returns   the process's exit code: check_failed where something is worse beyond noise (docs/reference/formats.md)
int compareMain(int argc, char** argv);

}  // namespace nlg
