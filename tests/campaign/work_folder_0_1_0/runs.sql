BEGIN TRANSACTION;
CREATE TABLE about (
	schema_version INTEGER NOT NULL, 
	PRIMARY KEY (schema_version)
);
INSERT INTO "about" VALUES(3);
CREATE TABLE calibrations (
	identity VARCHAR(32) NOT NULL, 
	name TEXT NOT NULL, 
	definition JSON NOT NULL, 
	status VARCHAR(16) NOT NULL, 
	started FLOAT NOT NULL, 
	known JSON DEFAULT '[]' NOT NULL, 
	number INTEGER DEFAULT '0' NOT NULL, 
	about JSON DEFAULT '{}' NOT NULL, 
	PRIMARY KEY (identity)
);
INSERT INTO "calibrations" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8','beads','{"tests": {"command": "ec2a52d49d27efa866c6e7a219f565f8"}, "parameters": [{"name": "friction", "minimum": 0.1, "maximum": 0.9, "scale": "linear", "unit": ""}], "targets": [{"name": "angle", "value": 27.0, "uncertainty": 0.6, "tolerance": null, "weight": 1.0, "unit": ""}], "strategy": "sequential", "seed": 1, "options": {"design_runs": 4, "prefer": "time_step", "extend_intervals": false, "confidence": 0.95}}','calibrated',1.79535815067892432208e+09,'[]',1,'{"learnt": [], "version": "0.1.0", "workers": 1, "max_runs": null, "provenance": {"file": "", "text": "", "fixed": {}, "units": {}}}');
CREATE TABLE requests (
	calibration VARCHAR(32) NOT NULL, 
	position INTEGER NOT NULL, 
	stage VARCHAR(16) NOT NULL, 
	parameters JSON NOT NULL, 
	seed BIGINT NOT NULL, 
	runs JSON NOT NULL, 
	PRIMARY KEY (calibration, position)
);
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',1,'design','{"friction": 0.2}',601029261,'{"command": "5f37564a98740f040199f26aac605610"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',2,'design','{"friction": 0.4}',558717084,'{"command": "2fdd8e590323e8943976e46fe70e7f48"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',3,'design','{"friction": 0.6}',203802527,'{"command": "69f3b6facafc9258ceb64f21cf7510db"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',4,'design','{"friction": 0.8}',877150603,'{"command": "49620ad6980fd8d46ea66bbbc63195f7"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',5,'optimisation','{"friction": 0.5801400297782037}',742229532,'{"command": "000e15c1cfae290a1815c69d2c3d7345"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',6,'optimisation','{"friction": 0.5697411286163846}',81123552,'{"command": "0f17ed0f526b3387aba5ee334cef9a61"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',7,'optimisation','{"friction": 0.5788983906925308}',706327612,'{"command": "4d1e5ef6b07dbd8c7120b58aa02013aa"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',8,'optimisation','{"friction": 0.5861983002492719}',358465164,'{"command": "89fd317385e7f41de7339a4b2857eb05"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',9,'optimisation','{"friction": 0.5846044604276743}',330499043,'{"command": "e433b98e33463781ce2afcf9a49674b1"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',10,'optimisation','{"friction": 0.5880342095455758}',645592729,'{"command": "7d0f088fea8059911bc5fe370dde512d"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',11,'optimisation','{"friction": 0.5910751027138349}',766669220,'{"command": "0ff72db750585523484f049bf2f43490"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',12,'optimisation','{"friction": 0.5846044604276743}',374386687,'{"command": "ded9a57fa13944f541cc795ab34be637"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',13,'verification','{"friction": 0.5836456620427863}',830043461,'{"command": "afedecae78cfcaec018bad1436b2c036"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',14,'verification','{"friction": 0.5836456620427863}',266241599,'{"command": "7e24d33b18ac39b5f3b5a97c6f9dd274"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',15,'verification','{"friction": 0.5836456620427863}',222189701,'{"command": "a1c3467b134abfe39c6003e6afbb96e8"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',16,'verification','{"friction": 0.5836456620427863}',527607827,'{"command": "ee6fda182af2a8af542246b6746aa537"}');
INSERT INTO "requests" VALUES('c07ad47fc8f342da9fe9f832d2bc82a8',17,'verification','{"friction": 0.5836456620427863}',86301333,'{"command": "d018760b16917ab746cb562c6fd5a34a"}');
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
	origin TEXT DEFAULT '' NOT NULL, 
	owner TEXT DEFAULT '' NOT NULL, 
	beat INTEGER DEFAULT '0' NOT NULL, 
	PRIMARY KEY (identity)
);
INSERT INTO "runs" VALUES('5f37564a98740f040199f26aac605610','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.2}, "seed": 601029261}','{"angle": {"value": 11.7467789890981, "standard_error": 0.0}}','','','',4.67967300000964314676e-02,1.79535815080272936816e+09,'','',0);
INSERT INTO "runs" VALUES('2fdd8e590323e8943976e46fe70e7f48','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.4}, "seed": 558717084}','{"angle": {"value": 17.9826560951437, "standard_error": 0.0}}','','','',3.82253849993503536097e-02,1.79535815088434934621e+09,'','',0);
INSERT INTO "runs" VALUES('69f3b6facafc9258ceb64f21cf7510db','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.6}, "seed": 203802527}','{"angle": {"value": 28.1650148662042, "standard_error": 0.0}}','','','',3.28340189998925779946e-02,1.79535815094296312332e+09,'','',0);
INSERT INTO "runs" VALUES('49620ad6980fd8d46ea66bbbc63195f7','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.8}, "seed": 877150603}','{"angle": {"value": 42.1630327056492, "standard_error": 0.0}}','','','',3.87765049999870825558e-02,1.79535815102483057971e+09,'','',0);
INSERT INTO "runs" VALUES('000e15c1cfae290a1815c69d2c3d7345','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5801400297782037}, "seed": 742229532}','{"angle": {"value": 26.3786678017054, "standard_error": 0.0}}','','','',0.0580472080000618,1.79535815141482043262e+09,'','',0);
INSERT INTO "runs" VALUES('0f17ed0f526b3387aba5ee334cef9a61','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5697411286163846}, "seed": 81123552}','{"angle": {"value": 26.6826758285335, "standard_error": 0.0}}','','','',1.00709811000342597253e-01,1.7953581518805615902e+09,'','',0);
INSERT INTO "runs" VALUES('4d1e5ef6b07dbd8c7120b58aa02013aa','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5788983906925308}, "seed": 706327612}','{"angle": {"value": 26.6218759597185, "standard_error": 0.0}}','','','',4.26312969993887236341e-02,1.79535815233456444743e+09,'','',0);
INSERT INTO "runs" VALUES('89fd317385e7f41de7339a4b2857eb05','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5861983002492719}, "seed": 358465164}','{"angle": {"value": 27.4356344519362, "standard_error": 0.0}}','','','',4.68833479999375413171e-02,1.79535815271095371245e+09,'','',0);
INSERT INTO "runs" VALUES('e433b98e33463781ce2afcf9a49674b1','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5846044604276743}, "seed": 330499043}','{"angle": {"value": 26.6713695009068, "standard_error": 0.0}}','','','',2.84085800003595068119e-02,1.79535815323023033142e+09,'','',0);
INSERT INTO "runs" VALUES('7d0f088fea8059911bc5fe370dde512d','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5880342095455758}, "seed": 645592729}','{"angle": {"value": 27.0102224816776, "standard_error": 0.0}}','','','',3.71811329996489803306e-02,1.79535815350475978858e+09,'','',0);
INSERT INTO "runs" VALUES('0ff72db750585523484f049bf2f43490','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5910751027138349}, "seed": 766669220}','{"angle": {"value": 27.7117990605354, "standard_error": 0.0}}','','','',5.32375060001868405379e-02,1.7953581537236630917e+09,'','',0);
INSERT INTO "runs" VALUES('ded9a57fa13944f541cc795ab34be637','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5846044604276743}, "seed": 374386687}','{"angle": {"value": 26.8497639508573, "standard_error": 0.0}}','','','',2.97604900006263051182e-02,1.79535815402362465857e+09,'','',0);
INSERT INTO "runs" VALUES('afedecae78cfcaec018bad1436b2c036','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5836456620427863}, "seed": 830043461}','{"angle": {"value": 27.2357799380949, "standard_error": 0.0}}','','','',4.06311830001868656836e-02,1.79535815427327251434e+09,'','',0);
INSERT INTO "runs" VALUES('7e24d33b18ac39b5f3b5a97c6f9dd274','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5836456620427863}, "seed": 266241599}','{"angle": {"value": 27.3299325644576, "standard_error": 0.0}}','','','',6.87561710001318715512e-02,1.79535815440414166449e+09,'','',0);
INSERT INTO "runs" VALUES('a1c3467b134abfe39c6003e6afbb96e8','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5836456620427863}, "seed": 222189701}','{"angle": {"value": 27.3626382136152, "standard_error": 0.0}}','','','',1.98359129999516881071e-02,1.79535815447555589675e+09,'','',0);
INSERT INTO "runs" VALUES('ee6fda182af2a8af542246b6746aa537','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5836456620427863}, "seed": 527607827}','{"angle": {"value": 27.2437085803149, "standard_error": 0.0}}','','','',4.2979193999599374365e-02,1.79535815462272834775e+09,'','',0);
INSERT INTO "runs" VALUES('d018760b16917ab746cb562c6fd5a34a','command','finished','{"solver": "command", "command": ["./simulate.sh", "{{ friction }}", "{{ seed }}"], "templates": ["*.j2"], "responses": "responses.json", "files": {"simulate.sh": "f1cc0ac0d9ff9eb2d0d6d425e976f73a81b44108d667692ece515670c696559e"}, "evaluate": null, "parameters": {"friction": 0.5836456620427863}, "seed": 86301333}','{"angle": {"value": 27.0811714148045, "standard_error": 0.0}}','','','',3.05842540001322049647e-02,1.79535815468262529379e+09,'','',0);
CREATE INDEX ix_runs_status ON runs (status);
COMMIT;
