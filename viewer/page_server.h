// Serves the viewer's page on 127.0.0.1, for browsers on this machine only.
//
//     /             the page, which is told that it is served (data-served)
//     /state        what goes on, as JSON: shown, a number that is another one for every set of scripts; text; failed; busy, and then
//                   stage, how far a bake is in words, and share, of that stage, or null
//     /NAME.js?N    a script of the set N
//
// Everything comes out of memory. A client has two seconds to ask and thirty to be answered, and a connection of its own for each
// request, so that none holds the page or its end. Another site may find a page on 127.0.0.1 by giving it a name of its own; requests for any name but
// this address are refused, and so is what another site includes of it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace nlg {

struct Stage {
  std::string name;             // "sample points lit"; empty: none is known
  std::optional<double> share;  // of it, 0 … 1; of what cannot be counted: none
};

class PageServer {
 public:
  // port     0: any that is free
  // throws   UsageError when it is taken; ThreadError
  explicit PageServer(int port);
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/"; }

  // From here on the page shows these scripts, by file name.
  void show(std::map<std::string, std::string> scripts);
  enum class Mood { fine, busy, failed };
  void tell(const std::string& text, Mood mood);
  // How far what was told of is; until the next tell.
  void tellStage(const Stage& stage);

 private:
  void addPage();

  class Server;
  std::unique_ptr<Server> server_;
  int port_ = 0;
  std::mutex mutex_;  // of all below
  uint64_t shown_;    // begins with the time: a page that stays open over two servers sees other numbers
  std::map<std::string, std::string> scripts_;
  std::string text_;
  Mood mood_ = Mood::fine;
  Stage stage_;
  std::thread thread_;
};

}  // namespace nlg
