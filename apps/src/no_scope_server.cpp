#include "scope_server.h"

namespace evenstep::app {

bool built_with_scope() { return false; }

Result<std::unique_ptr<ScopeServer>, std::string> open_scope_server(const ScopeServerOptions&) {
  return Failure{
      std::string("this evenstep was built without --scope; build it with EVENSTEP_SCOPE=ON, which needs Boost.Beast")};
}

}  // namespace evenstep::app
