// A build without SQLite and zlib: what needs them says so.
#include "profile_formats.h"

namespace evenstep::internal {
namespace {

class RefusedBytes : public Bytes {
 public:
  RefusedBytes() {
    error_ = "is gzipped, and this evenstep was built without zlib: unpack it first, or build with EVENSTEP_PROFILES=ON";
  }
  std::string_view next() override { return {}; }
};

}  // namespace

std::unique_ptr<Bytes> unpacked(std::unique_ptr<Bytes>) { return std::make_unique<RefusedBytes>(); }

void read_nsight_sqlite(ProfileInput&, const ProfileOptions&, ProfileBuilder& builder) {
  builder.profile().format = "SQLite";
  builder.fail("is a database, and this evenstep was built without SQLite: build it with EVENSTEP_PROFILES=ON");
}

}  // namespace evenstep::internal
