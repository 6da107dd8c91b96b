// Every operator new of the executable that links this counts.
#pragma once

namespace nlg {

// Calls of any operator new on this thread so far.
long allocationCount();

}  // namespace nlg
