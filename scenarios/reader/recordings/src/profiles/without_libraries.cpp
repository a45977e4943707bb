// A build without SQLite and zlib: what needs them says so.
#include "evenstep/time/build_option.h"
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

class RefusedBytes : public Bytes {
 public:
  RefusedBytes() { error_ = "is gzipped, and " + refusal_without(build_option::kProfiles, "unpack it first"); }
  std::string_view next() override { return {}; }
};

}  // namespace

std::unique_ptr<Bytes> unpacked(std::unique_ptr<Bytes>) { return std::make_unique<RefusedBytes>(); }

void read_sqlite(ProfileInput&, const ProfileOptions&, ProfileBuilder& builder) {
  builder.profile().format = "SQLite";
  builder.fail("is a database, and " + refusal_without(build_option::kProfiles, "export it as CSV"));
}

}  // namespace evenstep::internal
