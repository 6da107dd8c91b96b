// The threads of libtorch and OpenMP.
#pragma once

namespace nlg {

// Has libtorch work on the thread that calls it alone, whichever that is: what trains or exports splits its work itself, and a second
// team of threads would only be in the way. Call it before anything else of libtorch.
// others   threads that the tool starts besides, later
// throws   ThreadError when the system refuses as many threads
void useOneTorchThread(int others = 0);

}  // namespace nlg
