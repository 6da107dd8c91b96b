// nlg-validate frontier: error against run time of generators, their settings and every fit, on held-out functions.
#pragma once

namespace nlg {

int frontierMain(int argc, char** argv);

}  // namespace nlg
