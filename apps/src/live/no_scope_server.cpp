#include "scope_server.h"

#include "evenstep/time/build_option.h"

namespace evenstep::app {

bool built_with_scope() { return false; }

Result<std::unique_ptr<ScopeServer>, std::string> open_scope_server(const ScopeServerOptions&) {
  return Failure(refusal_without(build_option::kScope, kInsteadOfScope));
}

}  // namespace evenstep::app
