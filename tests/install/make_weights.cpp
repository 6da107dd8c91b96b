// Writes a weights file of random numbers: make_weights PATH REPRESENTATION [samples]. It loads, and nothing it yields needs no refinement.
#include <fstream>

#include "tests/runtime_eval/sample_dictionary.h"
#include "tests/runtime_eval/sample_generator.h"

int main(int argc, char** argv) {
  nlg::Representation representation;
  if (argc < 3 || argc > 4 || !nlg::findRepresentation(argv[2], &representation)) return 2;
  if (representation.isCode()) {
    const int count = representation.code_count;
    representation = nlg::Representation::code(nlg::sampleDictionary(9, count, 1));
  }
  const nlg::GeneratorInput input = argc == 4 ? nlg::GeneratorInput::samples : nlg::GeneratorInput::coefficients;
  std::ofstream stream(argv[1], std::ios::binary);
  stream << nlg::serializeWeights(nlg::weightsFromGenerator(nlg::sampleGenerator(representation, 24, 3, 1, input)));
  return stream.flush() ? 0 : 1;
}
