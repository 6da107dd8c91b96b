// The threads of libtorch and OpenMP.
#pragma once

namespace nlg {

// Has libtorch work on `count` threads, the calling one among them. Call it before anything else of libtorch.
// others   threads that the tool starts besides, later
// throws   ThreadError when the system refuses as many threads
void setTorchThreads(int count, int others = 0);

}  // namespace nlg
