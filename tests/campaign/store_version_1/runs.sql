BEGIN TRANSACTION;
CREATE TABLE about (
	schema_version INTEGER NOT NULL, 
	PRIMARY KEY (schema_version)
);
INSERT INTO "about" VALUES(1);
CREATE TABLE calibrations (
	identity VARCHAR(32) NOT NULL, 
	name TEXT NOT NULL, 
	definition JSON NOT NULL, 
	status VARCHAR(16) NOT NULL, 
	started FLOAT NOT NULL, 
	PRIMARY KEY (identity)
);
INSERT INTO "calibrations" VALUES('1bcc1192f73015d473e78eb7bbd801b3','beads','{"tests": {"command": "ec2a52d49d27efa866c6e7a219f565f8"}, "parameters": [{"name": "friction", "minimum": 0.1, "maximum": 0.9, "scale": "linear", "unit": ""}], "targets": [{"name": "angle", "value": 27.0, "uncertainty": null, "tolerance": 0.6, "weight": 1.0, "unit": ""}], "strategy": "sequential", "seed": 1, "options": {"design_runs": 4, "prefer": "time_step", "extend_intervals": false, "confidence": 0.95}}','interrupted',1.7952955985599052906e+09);
CREATE TABLE requests (
	calibration VARCHAR(32) NOT NULL, 
	position INTEGER NOT NULL, 
	stage VARCHAR(16) NOT NULL, 
	parameters JSON NOT NULL, 
	seed BIGINT NOT NULL, 
	runs JSON NOT NULL, 
	PRIMARY KEY (calibration, position)
);
INSERT INTO "requests" VALUES('1bcc1192f73015d473e78eb7bbd801b3',1,'design','{"friction": 0.2}',601029261,'{"command": "5f37564a98740f040199f26aac605610"}');
INSERT INTO "requests" VALUES('1bcc1192f73015d473e78eb7bbd801b3',2,'design','{"friction": 0.4}',558717084,'{"command": "2fdd8e590323e8943976e46fe70e7f48"}');
INSERT INTO "requests" VALUES('1bcc1192f73015d473e78eb7bbd801b3',3,'design','{"friction": 0.6}',203802527,'{"command": "69f3b6facafc9258ceb64f21cf7510db"}');
INSERT INTO "requests" VALUES('1bcc1192f73015d473e78eb7bbd801b3',4,'design','{"friction": 0.8}',877150603,'{"command": "49620ad6980fd8d46ea66bbbc63195f7"}');
INSERT INTO "requests" VALUES('1bcc1192f73015d473e78eb7bbd801b3',5,'optimisation','{"friction": 0.5801400297783516}',742229532,'{"command": "819e319c1eef0f3d0feb86c635dd4456"}');
INSERT INTO "requests" VALUES('1bcc1192f73015d473e78eb7bbd801b3',6,'optimisation','{"friction": 0.5697411286163846}',81123552,'{"command": "0f17ed0f526b3387aba5ee334cef9a61"}');
INSERT INTO "requests" VALUES('1bcc1192f73015d473e78eb7bbd801b3',7,'optimisation','{"friction": 0.5788983906918691}',706327612,'{"command": "5194c690a575e742943411615df517f5"}');
CREATE TABLE runs (
	identity VARCHAR(32) NOT NULL, 
	test TEXT NOT NULL, 
	status VARCHAR(16) NOT NULL, 
	definition JSON NOT NULL, 
	responses JSON NOT NULL, 
	reason TEXT NOT NULL, 
	kind VARCHAR(16) NOT NULL, 
	log_tail TEXT NOT NULL, 
	seconds FLOAT NOT NULL, 
	ended FLOAT NOT NULL, 
	PRIMARY KEY (identity)
);
INSERT INTO "runs" VALUES('5f37564a98740f040199f26aac605610','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.2}, "seed": 601029261}','{"angle": {"value": 11.7467789890981, "standard_error": 0.0}}','','','',1.54586799999378854408e-02,1.79529559858367419237e+09);
INSERT INTO "runs" VALUES('2fdd8e590323e8943976e46fe70e7f48','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.4}, "seed": 558717084}','{"angle": {"value": 17.9826560951437, "standard_error": 0.0}}','','','',1.07940889993187738582e-02,1.79529559860042524331e+09);
INSERT INTO "runs" VALUES('69f3b6facafc9258ceb64f21cf7510db','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.6}, "seed": 203802527}','{"angle": {"value": 28.1650148662042, "standard_error": 0.0}}','','','',1.14900829994439845904e-02,1.79529559861739921571e+09);
INSERT INTO "runs" VALUES('49620ad6980fd8d46ea66bbbc63195f7','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.8}, "seed": 877150603}','{"angle": {"value": 42.1630327056492, "standard_error": 0.0}}','','','',1.80668639986834023147e-02,1.79529559864117455479e+09);
INSERT INTO "runs" VALUES('819e319c1eef0f3d0feb86c635dd4456','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5801400297783516}, "seed": 742229532}','{"angle": {"value": 26.378667801714, "standard_error": 0.0}}','','','',6.22922900038247462362e-03,1.79529559875882101056e+09);
INSERT INTO "runs" VALUES('0f17ed0f526b3387aba5ee334cef9a61','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5697411286163846}, "seed": 81123552}','{"angle": {"value": 26.6826758285335, "standard_error": 0.0}}','','','',8.71856500089052133262e-03,1.79529559879971575735e+09);
INSERT INTO "runs" VALUES('5194c690a575e742943411615df517f5','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5788983906918691}, "seed": 706327612}','{"angle": {"value": 26.6218759596802, "standard_error": 0.0}}','','','',9.53856500018446240574e-03,1.79529559884378147128e+09);
CREATE INDEX ix_runs_status ON runs (status);
COMMIT;
