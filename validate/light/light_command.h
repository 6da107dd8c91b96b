// nlg-validate light: what every method makes of a scene's light, against ground truth.
#pragma once

namespace nlg {

int lightMain(int argc, char** argv);

}  // namespace nlg
