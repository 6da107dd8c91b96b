// nlg-validate light-closure: whether what a level holds of light explains the lightmaps that its compiler left.
#pragma once

namespace nlg {

int lightClosureMain(int argc, char** argv);

}  // namespace nlg
