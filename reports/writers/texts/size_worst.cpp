#include <fmt/format.h>

#include "size_conclusion.h"

namespace evenstep::internal {

std::string worst_order_text(const SizeRecord& record) {
  if (!record.worst_order) return "";
  const SizeWorstOrder& worst = *record.worst_order;
  std::string out = fmt::format(
      "\n  What if its hitches came together: the same segments in other orders, {} hitches among them, in any {:.6g} s at "
      "most {}, as recorded\n"
      "  {:<13} {:>18} {:>13} {:>23} {:>13} {:>13}\n",
      worst.hitches, seconds(worst.span), worst.together, "", "as recorded, ms", "lead, ms", "worst order found, ms",
      "lead, ms", "orders tried");
  for (const SizeWorstOrder::Map& map : worst.maps)
    out += fmt::format("  {:<13} {:>18.6f} {:>13.6f} {:>23.6f} {:>13.6f} {:>13}\n", map.name, ms(map.latency), ms(map.lead),
                       ms(map.worst_latency), ms(map.worst_lead), map.tried);
  out += "  Exact for the order recorded; the worst order is found, not proved: a worse one may exist.";
  if (!worst.file.empty()) out += fmt::format("\n  That of {} is in {}, for [timing] trace.", worst.map, worst.file);
  return out + "\n";
}

}  // namespace evenstep::internal
