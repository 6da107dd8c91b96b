// Files that are given together, no two of which may be the same thing: two weights of one representation, one shard twice.
#pragma once

#include <map>
#include <string>

namespace nlg {

class OneFileEach {
 public:
  // flag   what the files are given with: "--weights"; kind: what each of them is the only one of: "representation"
  OneFileEach(std::string flag, std::string kind);

  // what     the file's own: "tent_mlp"
  // throws   UsageError naming flag, `what` and both files when an earlier file was the same
  void add(const std::string& path, const std::string& what);

 private:
  std::string flag_, kind_;
  std::map<std::string, std::string> path_of_;
};

}  // namespace nlg
