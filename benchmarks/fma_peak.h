// The machine's limit, measured beside what is judged by it.
#pragma once

namespace nlg {

// Runs `rounds` rounds of independent fused multiply-adds on registers of the widest vectors that Highway uses here.
// returns   how many multiply-adds (scalar) that were
double runFusedMultiplyAdds(int rounds);

}  // namespace nlg
