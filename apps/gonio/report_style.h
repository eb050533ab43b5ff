// SPDX-License-Identifier: Apache-2.0
// The style sheet of a report.

#pragma once

namespace gonio {

inline constexpr const char* kReportStyle = R"css(
:root { color-scheme: light; --ink: #1f2933; --soft: #616e7c; --line: #e4e7eb; }
* { box-sizing: border-box; }
body { margin: 0; background: #f5f7fa; color: var(--ink); line-height: 1.5;
  font: 16px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 2.5rem 1.5rem 4rem; }
header p { margin: 0; color: var(--soft); }
header .kind { font-size: 0.8rem; letter-spacing: 0.08em; text-transform: uppercase; }
h1 { margin: 0.1rem 0 0.2rem; font-size: 2.1rem; line-height: 1.2; font-weight: 650; }
h2 { margin: 0 0 1rem; font-size: 1.2rem; font-weight: 650; }
section, .tile { background: #fff; border: 1px solid var(--line); border-radius: 10px; }
section { margin-top: 1.25rem; padding: 1.4rem 1.6rem; }
.tiles { display: grid; gap: 0.8rem; margin: 1.5rem 0 1rem;
  grid-template-columns: repeat(auto-fit, minmax(180px, 1fr)); }
.tile { padding: 0.9rem 1.1rem; }
.tile b { display: block; font-size: 1.5rem; font-weight: 650; line-height: 1.25; }
.tile span { display: block; font-size: 0.9rem; }
.tile small { display: block; color: var(--soft); font-size: 0.78rem; line-height: 1.35; }
.good, .warnings { margin: 0; padding: 0.7rem 1.1rem; border-radius: 10px; font-size: 0.92rem; }
.good { background: #e6f6f1; }
.warnings { background: #fff4dd; padding-left: 2.2rem; }
figure { margin: 0; }
figure > svg { display: block; width: 100%; height: auto; max-width: 860px; margin: 0 auto; }
figure svg * { font-family: inherit; }
#lobe > svg { max-width: none; }
.grid { display: grid; gap: 1rem 1.5rem; grid-template-columns: repeat(2, minmax(0, 1fr)); }
figcaption, .caption { max-width: 860px; margin: 0.8rem auto 0; color: var(--soft);
  font-size: 0.88rem; }
table { border-collapse: collapse; font-size: 0.88rem; font-variant-numeric: tabular-nums; }
th { font-weight: 550; color: var(--soft); text-align: left; }
td, th { padding: 0.3rem 0.8rem 0.3rem 0; vertical-align: top; }
.facts td { overflow-wrap: anywhere; }
.facts th { white-space: nowrap; padding-right: 1.6rem; }
.numbers { margin: 1rem auto 0; }
.numbers td, .numbers th { text-align: right; padding: 0.28rem 0.45rem;
  border-bottom: 1px solid var(--line); white-space: nowrap; }
.numbers .text, .numbers th:first-child { text-align: left; }
.numbers i { color: var(--soft); font-style: normal; }
.wide { overflow-x: auto; font-size: 0.95em; }
code { font-size: 0.85em; background: #f0f2f5; padding: 0.1em 0.35em; border-radius: 4px;
  overflow-wrap: anywhere; }
@media (max-width: 760px) { .grid { grid-template-columns: 1fr; } section { padding: 1rem; } }
@media print { body { background: #fff; } main { padding: 0; max-width: none; }
  section { break-inside: avoid; border: 0; padding: 0.5rem 0; } }
)css";

}  // namespace gonio
