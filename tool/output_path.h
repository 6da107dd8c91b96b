// Checks where a tool may write.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace nlg {

// An output that is an input would be gone for good.
// out, inputs   paths; an input that does not exist is none
// throws        UsageError naming the flag when it is empty, ends as a folder does or is the same file as one of the inputs
void refuseToReplaceInputs(const std::string& out, const std::vector<std::string>& inputs, const char* flag = "--out");

// Files that a tool writes, by which it knows them again.
struct OwnFiles {
  const char* name;                     // "a light grid"
  bool (*are)(std::string_view bytes);  // of the file's first 16 MiB
};

// Whether a text is among the bytes: the name of their kind, or of their tool.
inline bool hold(std::string_view bytes, std::string_view text) { return bytes.find(text) != std::string_view::npos; }

// What somebody else wrote would be gone for good, too: an existing file is replaced only where the tool wrote it, in whatever version,
// or where it is empty.
bool mayReplace(const std::string& out, const OwnFiles& own);
// throws   UsageError naming the flag where it may not
void refuseToReplaceOthers(const std::string& out, const OwnFiles& own, const char* flag = "--out");

// What --inputs and the environment's NLG_INPUTS write (input_file.h).
extern const OwnFiles kInputsFiles;

// Both: neither an input nor what somebody else wrote is replaced.
void refuseToReplace(const std::string& out, const std::vector<std::string>& inputs, const OwnFiles& own,
                     const char* flag = "--out");

// Whether files can be written into a folder, before a long run begins: it is one that may be written to, or can be made.
// throws        UsageError naming the flag when it is empty; OutputError with the system's reason
void requireOutputFolder(const std::string& out, const char* flag = "--out");

// Whether a file can be written, before a long run begins: it is no folder, and the folder that it lies in is as above. Says on
// stderr when that one is still to be made.
// throws        OutputError with the system's reason
void requireOutputFile(const std::string& out);

}  // namespace nlg
