;FLAVOR:Marlin
;TIME:61
;Filament used: 0.1m
;Layer height: 0.3
;MINX:20
;Generated with Cura_SteamEngine 5.7.1
M140 S60
M82 ;absolute extrusion mode
G21 ;metric values
G90 ;absolute positioning
G28 ;Home
G1 Z15.0 F6000 ;Move the platform down 15mm
G92 E0
G1 F200 E3
G92 E0
G0 X5 Y5 Z0.3 F3000
G1 X5 Y60 E2.0 F1200 ;Draw a prime line
G92 E0
;LAYER_COUNT:4
;LAYER:-1
M107
;MESH:NONMESH
G0 X30.000 Y30.000 Z0.300 F9000
;TYPE:SKIRT
G1 X30.000 Y30.000 E0.00000 F1500
G1 X70.000 Y30.000 E1.60000
G1 X70.000 Y70.000 E3.20000
G1 X30.000 Y70.000 E4.80000
G1 X30.000 Y30.000 E6.40000
;LAYER:0
M106 S85
;MESH:NONMESH
G0 X30.000 Y30.000 Z0.600 F9000
;MESH:tower.stl
G0 X41.000 Y41.000 F9000
;TYPE:WALL-INNER
G1 X41.000 Y41.000 E6.40000 F1800
G1 X59.000 Y41.000 E7.12000
G1 X59.000 Y59.000 E7.84000
G1 X41.000 Y59.000 E8.56000
G1 X41.000 Y41.000 E9.28000
G0 X40.000 Y40.000 F9000
;TYPE:WALL-OUTER
G1 X40.000 Y40.000 E9.28000 F1500
G1 X60.000 Y40.000 E10.08000
G1 X60.000 Y60.000 E10.88000
G1 X40.000 Y60.000 E11.68000
G1 X40.000 Y40.000 E12.48000
G0 X42.000 Y42.000 F9000
;TYPE:FILL
G1 X42.000 Y42.000 E12.48000
G1 X42.000 Y58.000 E13.12000
G1 X46.000 Y58.000 E13.28000
G1 X46.000 Y42.000 E13.92000
G1 X50.000 Y42.000 E14.08000
G1 X50.000 Y58.000 E14.72000
G1 X54.000 Y58.000 E14.88000
G1 X54.000 Y42.000 E15.52000
G1 X58.000 Y42.000 E15.68000
G1 X58.000 Y58.000 E16.32000
G1 F2700 E11.32000
G0 X44.000 Y44.000 Z1.600 F9000
G1 F2700 E16.32000
;TIME_ELAPSED:10.5
;LAYER:1
M106 S170
;MESH:NONMESH
G0 X30.000 Y30.000 Z0.900 F9000
;MESH:tower.stl
G0 X41.000 Y41.000 F9000
;TYPE:WALL-INNER
G1 X41.000 Y41.000 E16.32000 F1800
G1 X59.000 Y41.000 E17.04000
G1 X59.000 Y59.000 E17.76000
G1 X41.000 Y59.000 E18.48000
G1 X41.000 Y41.000 E19.20000
G0 X40.000 Y40.000 F9000
;TYPE:WALL-OUTER
G1 X40.000 Y40.000 E19.20000 F1500
G1 X60.000 Y40.000 E20.00000
G1 X60.000 Y60.000 E20.80000
G1 X40.000 Y60.000 E21.60000
G1 X40.000 Y40.000 E22.40000
G0 X42.000 Y42.000 F9000
;TYPE:FILL
G1 X42.000 Y42.000 E22.40000
G1 X58.000 Y42.000 E23.04000
G1 X58.000 Y46.000 E23.20000
G1 X42.000 Y46.000 E23.84000
G1 X42.000 Y50.000 E24.00000
G1 X58.000 Y50.000 E24.64000
G1 X58.000 Y54.000 E24.80000
G1 X42.000 Y54.000 E25.44000
G1 X42.000 Y58.000 E25.60000
G1 X58.000 Y58.000 E26.24000
G1 F2700 E21.24000
G0 X44.000 Y44.000 Z1.900 F9000
G1 F2700 E26.24000
;TIME_ELAPSED:20.5
;LAYER:2
M106 S255
;MESH:NONMESH
G0 X30.000 Y30.000 Z1.200 F9000
;MESH:tower.stl
G0 X41.000 Y41.000 F9000
;TYPE:WALL-INNER
G1 X41.000 Y41.000 E26.24000 F1800
G1 X59.000 Y41.000 E26.96000
G1 X59.000 Y59.000 E27.68000
G1 X41.000 Y59.000 E28.40000
G1 X41.000 Y41.000 E29.12000
G0 X40.000 Y40.000 F9000
;TYPE:WALL-OUTER
G1 X40.000 Y40.000 E29.12000 F1500
G1 X60.000 Y40.000 E29.92000
G1 X60.000 Y60.000 E30.72000
G1 X40.000 Y60.000 E31.52000
G1 X40.000 Y40.000 E32.32000
G0 X42.000 Y42.000 F9000
;TYPE:SKIN
G1 X42.000 Y42.000 E32.32000
G1 X42.000 Y58.000 E32.96000
G1 X46.000 Y58.000 E33.12000
G1 X46.000 Y42.000 E33.76000
G1 X50.000 Y42.000 E33.92000
G1 X50.000 Y58.000 E34.56000
G1 X54.000 Y58.000 E34.72000
G1 X54.000 Y42.000 E35.36000
G1 X58.000 Y42.000 E35.52000
G1 X58.000 Y58.000 E36.16000
G1 F2700 E31.16000
G0 X44.000 Y44.000 Z2.200 F9000
G1 F2700 E36.16000
;TIME_ELAPSED:30.5
M140 S0
M107
G91 ;relative positioning
G1 E-1 F300
G1 Z+0.5 E-5 X-20 Y-20 F9000 ;move Z up a bit
G28 X0 Y0
M84
G90
M82
;End of Gcode
;SETTING_3 {"global_quality": "[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n[general]\nversion = 4\n"}
