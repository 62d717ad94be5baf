"""The style of the page: one column on a narrow screen, two or three on a wide one."""

STYLE = """
body { background: #f4f5f7; color: #1a1a1a; font-family: system-ui, sans-serif; font-size: 15px;
  overflow-wrap: anywhere; }
.nicegui-content { padding: 12px; max-width: 1500px; margin: 0 auto; display: block; }
h1 { font-size: 1.3rem; line-height: 1.3; margin: 0 0 4px; font-weight: 600; }
h2 { font-size: 1.05rem; line-height: 1.3; margin: 0 0 8px; font-weight: 600; }
h3 { font-size: 0.95rem; line-height: 1.3; margin: 8px 0 4px; font-weight: 600; }
p { margin: 4px 0 8px; }
.studio-columns { display: grid; column-gap: 12px; align-items: start; width: 100%;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 370px), 1fr)); }
.studio-column { min-width: 0; }
.panel { background: white; border: 1px solid #d5d8dc; border-radius: 6px; padding: 12px;
  margin-bottom: 12px; overflow-x: auto; }
.variable { display: grid; grid-template-columns: 1fr 138px; column-gap: 14px; align-items: center;
  margin-bottom: 6px; }
.variable .name { grid-column: 1 / 3; display: flex; justify-content: space-between; gap: 8px;
  flex-wrap: wrap; }
.variable .limits { color: #5f6368; font-size: 0.85em; }
.buttons { display: flex; flex-wrap: wrap; gap: 8px; align-items: center; margin: 4px 0; }
.drawing svg { width: 100%; max-width: 560px; height: auto; display: block; margin: 0 auto; }
.quantity { border-top: 1px solid #e6e8ea; padding: 4px 0; }
.quantity h3 { display: flex; justify-content: space-between; gap: 8px; margin: 2px 0; }
.quantity output { font-variant-numeric: tabular-nums; white-space: nowrap; }
.effect { display: grid; grid-template-columns: 11em 1em 1fr 8.5em; gap: 6px; font-size: 0.85em;
  align-items: center; color: #3c4043; }
.effect .track { height: 7px; background: #eef0f2; border-radius: 2px; overflow: hidden; }
.effect .bar { display: block; height: 100%; }
.bar.up { background: #0072b2; } .bar.down { background: #d55e00; }
.arrow.up { color: #0072b2; } .arrow.down { color: #d55e00; }
.effect .change { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.status { padding: 8px 10px; border-radius: 4px; font-weight: 600; }
.status.pass { background: #d9f0e6; color: #00573f; }
.status.warning { background: #fdf0d0; color: #6b4a00; }
.status.no-checks { background: #eceff1; color: #3c4043; }
.status.fail { background: #fbdfd0; color: #8a3200; }
.verdict { font-weight: 600; white-space: nowrap; } .unbroken { white-space: nowrap; }
.verdict.pass { color: #00694c; } .verdict.warning { color: #8a5f00; }
.verdict.fail { color: #b34700; } .verdict.no-limit, .verdict.note { color: #5f6368; }
table { border-collapse: collapse; width: 100%; font-size: 0.85em; margin: 6px 0 10px; }
caption { text-align: left; font-weight: 600; padding: 4px 0; }
th, td { text-align: left; padding: 3px 6px 3px 0; border-top: 1px solid #e6e8ea;
  overflow-wrap: break-word;
  vertical-align: top; font-weight: 400; font-variant-numeric: tabular-nums; }
thead th { color: #5f6368; border-top: 0; }
details, .q-expansion-item { font-size: 0.95em; }
ul { margin: 4px 0; padding-left: 18px; list-style: disc; font-size: 0.87em; } li { margin: 3px 0; }
.way { width: 100%; max-width: 420px; height: auto; }
.way polyline { fill: none; stroke: #5f6368; stroke-width: 1; }
.way circle.good { fill: #009e73; stroke: #009e73; }
.way circle.bad { fill: white; stroke: #5f6368; }
.error { color: #8a3200; font-weight: 600; min-height: 1em; }
.quiet { color: #5f6368; font-size: 0.9em; }
:focus-visible { outline: 2px solid #0072b2; outline-offset: 2px; }
@media (max-width: 500px) {
  .nicegui-content { padding: 6px; } .panel { padding: 8px; }
  .effect { grid-template-columns: 9.5em 1em 1fr 8.2em; gap: 4px; font-size: 0.8em; }
  table { font-size: 0.78em; } th, td { padding-right: 4px; }
}
"""
