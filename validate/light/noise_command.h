// nlg-validate light-noise: how noisy a level's baked light is, and how fast it is baked.
#pragma once

namespace nlg {

int lightNoiseMain(int argc, char** argv);

}  // namespace nlg
