// The commands of nlg-validate. Each returns the process's exit code.
#pragma once

namespace nlg {

// Error against run time of generators, their settings and every fit, on held-out functions.
int frontierMain(int argc, char** argv);
// What every method makes of a scene's light, against ground truth.
int lightMain(int argc, char** argv);
// Pictures of a scene by every method, against ground truth.
int viewsMain(int argc, char** argv);

}  // namespace nlg
