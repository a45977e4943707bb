#pragma once
/// Where the run folders of one call go.

#include <string>
#include <vector>

namespace evenstep::app {

/// One folder for each scenario file, in order; all different if the files are. A single file goes to `out` itself, if
/// given. Otherwise each has the name of its file, below `out` or the default place. Names of the folders above the file are
/// put in front where two files of this call would have the same place, or where the run of another file is there already
/// (which is reported).
std::vector<std::string> run_places(const std::vector<std::string>& files, const std::string& out);

}  // namespace evenstep::app
